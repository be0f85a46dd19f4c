"""The pass that adds up what each element of the scene hides, over the pixels within its reach."""

from __future__ import annotations

from collections.abc import Mapping

from ..graph.declare import Pass, Texture
from ..graph.draws import DrawElements, ViewValue, as_uniforms
from ..graph.names import HIDDEN, PIXEL_DEPTH, PIXEL_NORMAL
from ..methods.base import Method
from .occlusion import PIXEL

BIAS = (1e-3, 3e-4)
"""How far receivers are lifted off their surface, so that it does not hide itself: in radii, and of their distance, a
third of a pixel of 720 rows: by so much does SwiftShader's interpolated depth leave a plane, others' by 2e-7."""

SHADERS: Mapping[str, tuple[str, str]] = {
    "triangles": ("prisms.vert", "prisms.frag"),
    "spheres": ("sphere_splats.vert", "sphere_splats.frag"),
}


def add_elements(method: Method, scale: int) -> list[Pass]:
    """Return the pass that a method of elements reads; none for others. ``scale``: pixels to a texel, along each side."""
    traits, radius = method.traits.elements, method.radius
    if traits is None or radius is None:
        return []
    small = scale > 1
    given = {"u_bias": BIAS, "u_texel_reach": ViewValue("pixel", float(scale))}
    draw = DrawElements(
        traits.elements,
        SHADERS[traits.elements],
        radius,
        traits.patch * radius,
        {"u_pixel_z": PIXEL[small][PIXEL_DEPTH], "u_pixel_normal": PIXEL[small][PIXEL_NORMAL]},
        as_uniforms({**traits.constants, **given}),
        {**({"SMALL": 1} if small else {}), **({"BOTH_SIDES": 1} if traits.both_sides else {})},
    )
    sums = {HIDDEN: Texture("r32f" if traits.exact_sums else "r16f", 1 / scale)}
    return [Pass(f"{traits.elements} summed", "occlusion", draw, sums, clear=(0.0,) * 4, blend="add")]
