"""Visibility over frames: the noise of each in another phase, and their mean along what is seen (Bavoil & Andersson, "Stable SSAO
in Battlefield 3", GDC 2012, filter likewise). It buys stability: an error that all frames share stays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..graph.declare import Pass, Texture
from ..graph.draws import FloatTable, Fullscreen, Uniform, ViewValue
from ..graph.names import DEPTH, GIVEN_HISTORY, HISTORY, NORMAL, VISIBILITY, VISIBILITY_NOW
from ..sampling.disk import bayer

MOST_FRAMES = 16
"""Frames that count: as many as the noise tile has phases."""

TOLERANCE = 1.0
"""Pixels off its plane up to which what was seen is what is seen."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A frame of a sequence. phase: of its noise. moved: whether things moved in the world, so that visibility may have changed where
    depth has not: then no history counts beyond what the frame itself has around a pixel.
    """

    phase: int
    moved: bool = False


def averaged(screen: Sequence[Pass], *, moved: bool) -> list[Pass]:
    """Return the passes of visibility, and behind them the one that averages it with the last frames'; see :class:`Moment`."""
    samplers = {"u_now": VISIBILITY_NOW, "u_z": DEPTH, "u_normal": NORMAL, "u_history": GIVEN_HISTORY}
    uniforms: dict[str, Uniform] = {"u_per_pixel": ViewValue("pixel", TOLERANCE, inverse=True), "u_most": float(MOST_FRAMES)}
    draw = Fullscreen("temporal.frag", samplers, uniforms, defines={"TARGETS": 2, **({"MOVED": 1} if moved else {})})
    targets = {VISIBILITY: Texture("r8"), HISTORY: Texture("rgba32f")}
    done = Pass("temporal", "denoise", draw, targets, clear=(0.0,) * 4)
    return [*(task.renamed(VISIBILITY, VISIBILITY_NOW) for task in screen), done]


def in_phase(task: Pass, tile: int, phase: int) -> Pass:
    """Return a pass of occlusion whose noise tile of so many pixels is moved to another place for each phase; 0: as it is."""
    if task.role != "occlusion" or not isinstance(task.draw, Fullscreen) or tile < 2:
        return task
    place = int(np.flatnonzero(bayer(tile).ravel() == phase % tile**2)[0])
    start = int(np.flatnonzero(bayer(tile).ravel() == 0)[0])
    shift = place // tile - start // tile, place % tile - start % tile

    def moved(table: FloatTable) -> FloatTable:
        return FloatTable.of(np.roll(table.array(), shift, (0, 1))) if table.shape[:2] == (tile, tile) else table

    return replace(task, draw=replace(task.draw, tables={name: moved(table) for name, table in task.draw.tables.items()}))
