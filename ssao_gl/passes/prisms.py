"""The pass that adds up what each triangle of the scene hides, over the pixels within its reach."""

from __future__ import annotations

from ..graph.declare import Pass, Texture
from ..graph.draws import DrawPrisms, ViewValue
from ..graph.names import HIDDEN, PIXEL_DEPTH, PIXEL_NORMAL
from ..methods.base import Method
from .occlusion import PIXEL

BIAS = (1e-3, 3e-4)
"""How far receivers are lifted off their surface, so that it does not hide itself: in radii, and of their distance, a
third of a pixel of 720 rows: by so much does SwiftShader's interpolated depth leave a plane, others' by 2e-7."""


def add_prisms(method: Method, scale: int) -> list[Pass]:
    """Return the pass that a method of triangles reads; none for others. ``scale``: pixels to a texel, along each side."""
    prisms, radius = method.traits.prisms, method.radius
    if prisms is None or radius is None:
        return []
    small = scale > 1
    draw = DrawPrisms(
        ("prisms.vert", "prisms.frag"),
        radius,
        prisms.both_sides,
        {"u_pixel_z": PIXEL[small][PIXEL_DEPTH], "u_pixel_normal": PIXEL[small][PIXEL_NORMAL]},
        {"u_power": prisms.power, "u_bias": BIAS, "u_texel_reach": ViewValue("pixel", float(scale))},
        {"SMALL": 1} if small else {},
    )
    sums = {HIDDEN: Texture("r32f" if prisms.exact_sums else "r16f", 1 / scale)}
    return [Pass("prisms", "occlusion", draw, sums, clear=(0.0,) * 4, blend="add")]
