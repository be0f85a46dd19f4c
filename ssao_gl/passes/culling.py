"""Blocks of pixels from which nothing can be seen that hides anything: their visibility is 1 without a tap."""

from __future__ import annotations

from ..graph.declare import Pass, Texture
from ..graph.draws import Fullscreen, Uniform, ViewValue
from ..graph.names import (
    BLOCK_BOUNDS,
    BLOCK_OPEN,
    BLOCK_PROBE,
    BLOCK_SPREAD,
    DEPTH,
    NORMAL,
    SHADE_MASK,
    VISIBILITY_UNSHADED,
)  # fmt: skip

BLOCK = 16
"""Side of a block, pixels."""

TAPS = 12
"""Taps to a side of all slices of a pixel from which on looking for open blocks may pay."""
TRIANGLE = 8
"""Pixels for each triangle from which on faces may fill blocks."""


def bound_blocks() -> Pass:
    """Bound the surfaces of each block from the front."""
    defines = {"TARGETS": 2, "BLOCK": BLOCK, "BELOW": BLOCK + 1}
    draw = Fullscreen("block_bounds.frag", {"u_z": DEPTH, "u_normal": NORMAL}, defines=defines)
    targets = {BLOCK_BOUNDS: Texture("rgba32f", 1 / BLOCK), BLOCK_SPREAD: Texture("rgba32f", 1 / BLOCK)}
    return Pass("block bounds", "cull", draw, targets)


def open_blocks(radius: float, farthest: float, max_radius: float) -> Pass:
    """Find the blocks that are open: taps reach ``radius``, or ``max_radius`` pixels of it, and count up to ``farthest``.

    Both in scene units.
    """
    uniforms: dict[str, Uniform] = {
        "u_block_texel": ViewValue("target_texel"),
        "u_blocks": ViewValue("target_size"),
        "u_radius": radius,
        "u_farthest": farthest,
        "u_max_radius": max_radius,
        "u_pixel": ViewValue("pixel_smaller"),
    }
    samplers = {"u_bounds": BLOCK_BOUNDS, "u_spread": BLOCK_SPREAD}
    draw = Fullscreen("open_blocks.frag", samplers, uniforms, defines={"BLOCK": BLOCK})
    return Pass("open blocks", "cull", draw, {BLOCK_OPEN: Texture("r8", 1 / BLOCK)})


def open_blocks_by_probe() -> Pass:
    """Take the blocks for open whose probe and all around it are."""
    draw = Fullscreen("open_blocks_by_probe.frag", {"u_probe": BLOCK_PROBE})
    return Pass("open blocks", "cull", draw, {BLOCK_OPEN: Texture("r8", 1 / BLOCK)})


def shade_mask(*, packed: bool) -> Pass:
    """Tell at full size what there is to shade, and give the visibility of the rest; ``downsample`` does so at smaller sizes."""
    uniforms = {"u_per_block": PER_BLOCK}
    samplers = {"u_z": DEPTH, "u_open": BLOCK_OPEN}
    draw = Fullscreen("shade_mask.frag", samplers, uniforms, defines={"PACKED": 1} if packed else {})
    target, clear = (Texture("r32f"), (0.0,) * 4) if packed else (Texture("r8"), (1.0,) * 4)
    return Pass("shade mask", "cull", draw, {VISIBILITY_UNSHADED: target}, depth=SHADE_MASK, clear=clear)


PER_BLOCK = ViewValue("resource_size", BLOCK, inverse=True, resource=BLOCK_OPEN)
"""The uniform that finds the block of a pixel."""
