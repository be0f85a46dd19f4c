"""What a method that draws a volume for each element refuses before anything is drawn, and what it warns of."""

from __future__ import annotations

from ..errors import SettingsError, warn_of_input
from ..scene.ball_elements import ball_fill
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.prisms import prism_fill
from ..scene.projection import ViewConstants
from .settings import Settings, drawn_scale


def check_fill(settings: Settings, scene: Scene, camera: Camera, view: ViewConstants) -> None:
    """Raise SettingsError where the method's volumes would fill more than its limit, with what they fill and what to do.

    Warns of scenes that have what it does not know.
    """
    method = settings.method
    traits, radius = method.traits.elements, method.radius
    if traits is None or radius is None:
        return
    triangles = traits.elements == "triangles"
    if triangles and (scene.spheres or scene.volumes):
        warn_of_input(f"{method.name}: knows triangles alone; spheres and volumes hide nothing here")
    elif scene.volumes:
        warn_of_input(f"{method.name}: knows surfaces and spheres alone; volumes hide nothing here but in its near range")
    scale = drawn_scale(settings)
    w, h = (-(-side // scale) for side in view.size)
    if triangles:
        what = f"{scene.triangles:,} triangles"
        fill = prism_fill(scene, camera, view, (w, h), radius, both_sides=traits.both_sides)
    else:
        count, fill = ball_fill(scene, camera, view, (w, h), radius, traits.patch * radius)
        what = f"{count:,} spheres"
    if fill <= traits.max_fill:
        return
    cure = f"a radius below {radius:g}" if scale == 4 else f"{method.name}.scale=4, a radius below {radius:g}"
    raise SettingsError(
        f"{method.name}: {what} would fill about {fill / 1e6:,.0f} million fragments in {w}x{h} texels, more than"
        f" {method.name}.max_fill={traits.max_fill / 1e6:g}; use {cure}, a smaller picture or another method, or raise max_fill"
    )
