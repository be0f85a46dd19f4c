"""A summed-area table of inverse depth: the mean over any box is four look-ups."""

from __future__ import annotations

from ..graph.declare import Pass, Texture
from ..graph.draws import Fullscreen
from ..graph.names import DEPTH, DEPTH_RANGE, DEPTH_TABLE
from ..scene.projection import Size

BLOCK = 8
"""Texels along each side of which one step of the reduction to the range of depth takes the extremes."""

TABLE_SCALE = 4
"""Pixels of the image to a texel, along each side, where no method wants another."""

STEP = 4
"""How many texels a step of the table adds up."""


def depth_table(size: Size, scale: int) -> list[Pass]:
    """Sum inverse depth and coverage over every ``scale``-th pixel of an image of ``size``: the table's texel holds the sums over
    all to its left and below, itself included. See ``shaders/lib/depth_table.glsl``."""
    return [*_ranges(size, scale), *_sums(size, scale)]


def _ranges(size: Size, scale: int) -> list[Pass]:
    """Reduce the image to the range of inverse depth that it shows."""
    passes, source, side, defines = [], DEPTH, scale, {"BLOCK": BLOCK, "SCALE": scale}
    while True:
        side *= BLOCK
        last = Texture("", 1 / side).size(size) == (1, 1)
        result = DEPTH_RANGE if last else f"{DEPTH_RANGE}_{side}"
        draw = Fullscreen("depth_range.frag", {"u_source": source}, defines=defines)
        passes.append(Pass(f"depth range {side}", "prepare", draw, {result: Texture("rgba32f", 1 / side)}))
        if last:
            return passes
        source, defines = result, {"BLOCK": BLOCK}


def _sums(size: Size, scale: int) -> list[Pass]:
    """Sum along rows, then along columns, in strides of 1, 4, 16, ..."""
    sides = Texture("", 1 / scale).size(size)
    # The first step makes the entries, also of a table that is a texel wide.
    steps = [(0, 1), *((axis, stride) for axis in (0, 1) for stride in _strides(sides[axis]) if (axis, stride) != (0, 1))]
    passes, source = [], ""
    for number, (axis, stride) in enumerate(steps, 1):
        result = DEPTH_TABLE if number == len(steps) else f"{DEPTH_TABLE}_{'xy'[axis]}{stride}"
        samplers = {"u_sums": source} if source else {"u_z": DEPTH, "u_range": DEPTH_RANGE}
        defines = {"SCALE": scale, "STRIDE_X": stride * (axis == 0), "STRIDE_Y": stride * (axis == 1)}
        draw = Fullscreen("depth_table.frag", samplers, defines={**defines, **({} if source else {"FIRST": 1}), "TARGETS": 1})
        passes.append(Pass(f"sum {'xy'[axis]} {stride}", "prepare", draw, {result: Texture("rgba32ui", 1 / scale)}))
        source = result
    return passes


def _strides(texels: int) -> list[int]:
    """Return the strides after which sums reach over that many texels."""
    return [STEP**i for i in range(32) if STEP**i < texels]
