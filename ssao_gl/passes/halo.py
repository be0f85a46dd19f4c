"""Halos: what lies behind the outline of something in front is painted over, by unsharp masking of depth."""

from __future__ import annotations

from collections.abc import Sequence

from ..graph.declare import Pass, Texture
from ..graph.draws import Fullscreen, Uniform, ViewValue
from ..graph.names import DEPTH, DEPTH_RANGE, DEPTH_TABLE, HALO_MEANS, IMAGE, IMAGE_WITHOUT_HALO


def paint_halo(color: Sequence[float], strength: float, width: float, radius: float, scale: int) -> list[Pass]:
    """Draw the image with halos. Luft, Colditz, Deussen, "Image Enhancement by Unsharp Masking the Depth Buffer", SIGGRAPH 2006.

    color: sRGB in 0..1. width: of the halo, as a share of the image's height. radius: scene units, in
    which steps of depth are measured. scale: of the depth table that the blurred depth is taken from.
    """
    samplers = {"u_range": DEPTH_RANGE, "u_sums": DEPTH_TABLE}
    uniforms: dict[str, Uniform] = {"u_share": ViewValue("image_share"), "u_width": width / scale}
    means = Fullscreen("halo_means.frag", samplers, uniforms, defines={"SCALE": scale})
    samplers = {"u_image": IMAGE_WITHOUT_HALO, "u_z": DEPTH, "u_means": HALO_MEANS}
    painted = Fullscreen(
        "halo.frag", samplers, {"u_radius": radius, "u_color": (*color[:3], strength)}, defines={"SCALE": scale}
    )
    return [
        Pass("halo means", "prepare", means, {HALO_MEANS: Texture("rgba32f", 1 / scale)}),
        Pass("halo", "composite", painted, {IMAGE: Texture("rgba8")}),
    ]
