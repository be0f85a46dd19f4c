"""Visibility over frames: the noise of each in another phase, and their mean along what is seen (Bavoil & Andersson, "Stable SSAO
in Battlefield 3", GDC 2012, filter likewise). It buys stability: an error that all frames share stays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..graph.declare import Pass, Texture
from ..graph.draws import FloatTable, Fullscreen, Uniform, ViewValue
from ..graph.names import GIVEN_HISTORY, HISTORY, PIXEL_DEPTH, PIXEL_NORMAL, VISIBILITY, VISIBILITY_NOW
from ..sampling.disk import bayer
from .occlusion import PIXEL
from .resolution import upsampled_average

PHASES = 16
"""Places of the noise tile, which frames take in turn."""

MOST_FRAMES = 24
"""Frames that count. Of 16, 24 and 32 this one leaves least flicker (``draft``, a pan of a quarter of a pixel a frame)."""

TOLERANCE = 1.0
"""Texels off its plane up to which what was seen is what is seen."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A frame of a sequence. phase: of its noise. moved: whether things moved in the world, so that visibility may have changed where
    depth has not: then no history counts beyond what the frame itself has around a pixel.
    """

    phase: int
    moved: bool = False


def averaged(screen: Sequence[Pass], result: str = VISIBILITY, scale: int = 1, *, moved: bool) -> list[Pass]:
    """Return the passes of visibility, and the one that averages their ``result`` with the last frames'; see :class:`Moment`.

    ``scale`` above 1: the result is packed and small, with so many pixels along each side of a texel; the history is what is read of it.
    """
    small = scale > 1
    pixel = PIXEL[small]
    samplers = {
        "u_now": VISIBILITY_NOW,
        "u_pixel_z": pixel[PIXEL_DEPTH],
        "u_pixel_normal": pixel[PIXEL_NORMAL],
        "u_history": GIVEN_HISTORY,
    }
    uniforms: dict[str, Uniform] = {
        "u_per_pixel": ViewValue("pixel", TOLERANCE * scale, inverse=True),
        "u_most": float(MOST_FRAMES),
    }
    defines = {"TARGETS": 1 if small else 2, **({"MOVED": 1} if moved else {}), **({"PACKED": 1, "SMALL": 1} if small else {})}
    draw = Fullscreen("temporal.frag", samplers, uniforms, defines=defines)
    targets = {HISTORY: Texture("rgba32f", 1 / scale), **({} if small else {result: Texture("r8")})}
    done = Pass("temporal", "denoise", draw, targets, clear=(0.0,) * 4)
    passes = [task.renamed(result, VISIBILITY_NOW) for task in screen]
    return [*(upsampled_average(task, result) for task in passes), done] if small else [*passes, done]


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
