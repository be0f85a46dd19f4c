"""What a method that draws a prism for each triangle refuses before anything is drawn, and what it warns of."""

from __future__ import annotations

from ..errors import SettingsError, warn_of_input
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.prisms import prism_fill
from ..scene.projection import ViewConstants
from .settings import Settings, drawn_scale


def check_fill(settings: Settings, scene: Scene, camera: Camera, view: ViewConstants) -> None:
    """Raise SettingsError where the method's prisms would fill more than its limit, with what they fill and what to do.

    Warns of scenes that have more than triangles.
    """
    method = settings.method
    prisms, radius = method.traits.prisms, method.radius
    if prisms is None or radius is None:
        return
    if scene.spheres or scene.volumes:
        warn_of_input(f"{method.name}: knows triangles alone; spheres and volumes hide nothing here")
    scale = drawn_scale(settings)
    w, h = (-(-side // scale) for side in view.size)
    fill = prism_fill(scene, camera, view, (w, h), radius, both_sides=prisms.both_sides)
    if fill <= prisms.max_fill:
        return
    cure = f"a radius below {radius:g}" if scale == 4 else f"{method.name}.scale=4, a radius below {radius:g}"
    raise SettingsError(
        f"{method.name}: {scene.triangles:,} triangles would fill about {fill / 1e6:,.0f} million fragments in {w}x{h} texels, more than"
        f" {method.name}.max_fill={prisms.max_fill / 1e6:g}; use {cure}, a smaller picture or another method, or raise max_fill"
    )
