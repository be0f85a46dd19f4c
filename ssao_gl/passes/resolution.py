"""Occlusion at a smaller size: shrink depth and normals, bring visibility back to full size, mend what that misses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Define, Fullscreen, Uniform, ViewValue
from ..graph.names import (
    BLOCK_OPEN,
    DEPTH,
    DEPTH_SMALL,
    HISTORY,
    NORMAL,
    NORMAL_SMALL,
    REFINE_MASK,
    SHADE_MASK,
    VISIBILITY,
    VISIBILITY_UNSHADED,
    VISIBILITY_UPSAMPLED,
)  # fmt: skip
from .culling import PER_BLOCK
from .extra_signals import extra_signals

EDGE = 30.0
"""Depths that differ by more, in the size of a pixel, are of two surfaces, which take turns. Elsewhere the same pixel is kept
everywhere: an even grid is what interpolation is exact on."""

SAME = 0.25
"""Radii of difference in depth up to which a texel shows the pixel's surface, where there is no normal to tell."""


def downsample(scale: int, *, open_blocks: bool) -> Pass:
    """Keep depth and normal of one pixel of each ``scale`` x ``scale``, and tell which of them there is to shade."""
    defines: dict[str, Define] = {"SCALE": scale, "PIXELS": scale * scale, "TARGETS": 2}
    samplers = {"u_z": DEPTH, "u_normal": NORMAL}
    uniforms: dict[str, Uniform] = {"u_edge": ViewValue("pixel", EDGE)}
    writes = {DEPTH_SMALL: Texture("r32f", 1 / scale), NORMAL_SMALL: Texture("rg16f", 1 / scale)}
    if open_blocks:
        defines |= {"OPEN": 1, "PACKED": 1, "TARGETS": 3}
        samplers |= {"u_open": BLOCK_OPEN}
        uniforms |= {"u_per_block": PER_BLOCK}
        writes |= {VISIBILITY_UNSHADED: Texture("r32f", 1 / scale)}
    draw = Fullscreen("downsample.frag", samplers, uniforms, defines=defines)
    return Pass("downsample", "prepare", draw, writes, depth=SHADE_MASK, clear=(0.0,) * 4)


def upsample(
    source: str, scale: int, tolerance: float, mask: DepthTest | None, refine_below: float, *, signals: Sequence[str] = ()
) -> Pass:
    """Bring ``source`` (packed, small) to the size of the image.

    Texels count in full up to ``tolerance`` of theirs off the tangent plane. ``refine_below`` above 0: leave a mask of the
    pixels whose texels together weigh less, to be drawn again.
    """
    result = VISIBILITY_UPSAMPLED if refine_below else VISIBILITY
    more = extra_signals(signals, source, result)
    defines: dict[str, Define] = {"PACKED": 1, **({"REFINE": 1} if refine_below else {}), **more.defines}
    samplers = {"u_packed": source, "u_z": DEPTH, "u_normal": NORMAL, "u_small_normal": NORMAL_SMALL, **more.samplers}
    uniforms: dict[str, Uniform] = {
        "u_small_texel": ViewValue("resource_size", inverse=True, resource=source),
        "u_small_scale": float(scale),
        "u_per_pixel": ViewValue("pixel", tolerance * scale, inverse=True),
        **({"u_least": refine_below} if refine_below else {}),
    }
    draw = Fullscreen("upsample.frag", samplers, uniforms, defines=defines)
    writes = {result: Texture("r8"), **more.writes}
    if refine_below:  # a pass that writes depth cannot be tested against another
        return Pass("upsample", "upsample", draw, writes, depth=REFINE_MASK, clear=(1.0,) * 4)
    return Pass("upsample", "upsample", draw, writes, test=mask, clear=(1.0,) * 4)


def upsampled_average(task: Pass, source: str) -> Pass:
    """Return a pass, which brings the average over frames to the size of the image if it did so with ``source``."""
    if task.role != "upsample" or not isinstance(task.draw, Fullscreen):
        return task
    draw = task.draw
    samplers = {name: HISTORY if resource == source else resource for name, resource in draw.samplers.items()}
    uniforms = {**draw.uniforms, "u_small_texel": ViewValue("resource_size", inverse=True, resource=HISTORY)}
    return replace(task, draw=replace(draw, samplers=samplers, uniforms=uniforms, defines={**draw.defines, "AVERAGED": 1}))


def upsample_by_depth(source: str, scale: int, radius: float, mask: DepthTest | None) -> Pass:
    """Bring ``source`` (packed, small, of the first of each block's pixels) to the size of the image by depth alone.

    Texels count in full up to ``SAME`` of the ``radius`` before or behind the pixel.
    """
    samplers = {"u_packed": source, "u_z": DEPTH}
    uniforms: dict[str, Uniform] = {"u_small_scale": float(scale), "u_per_depth": 1 / (SAME * radius)}
    draw = Fullscreen("upsample_depth.frag", samplers, uniforms, defines={"PACKED": 1})
    return Pass("upsample", "upsample", draw, {VISIBILITY: Texture("r8")}, test=mask, clear=(1.0,) * 4)
