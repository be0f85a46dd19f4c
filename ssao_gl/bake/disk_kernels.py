"""Occlusion by disks, compiled by numba. Importing this needs the package numba.

All sums are in 64-bit and go through a grid's cells in one order: the same bytes on any number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., object])
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
compiled = cast(Callable[[Function], Function], njit(nogil=True, cache=True))


@compiled
def transfer(gems: bool, area: float, r2: float, receiver: float, emitter: float) -> float:
    """Return the share of a point's cosine-weighted hemisphere that a disk takes, at the squared distance ``r2``.

    receiver, emitter: cosines, in 0..1. The default is ``A cos cos / (pi r^2 + A)``, which is exact on the axis: a^2 / (a^2 + h^2).
    gems: Bunnell's kernel, "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2 (2005), chapter 14, the solid angle
    ``1 - 1 / sqrt(A / (pi r^2) + 1)`` times ``cos_E min(1, 4 cos_R)``.
    """
    if gems:
        return (1 - 1 / math.sqrt(area / (math.pi * r2) + 1)) * emitter * min(1.0, 4 * receiver)
    return area * receiver * emitter / (math.pi * r2 + area)


@compiled
def cell_span(x: float, reach: float, cell: float, count: int) -> tuple[int, int]:
    """Return the first and the last cell of an axis of the grid, which begins at -1, that ``x - reach`` .. ``x + reach`` meets."""
    first, last = math.floor((x - reach + 1) / cell), math.floor((x + reach + 1) / cell)
    return max(0, min(count - 1, int(first))), max(0, min(count - 1, int(last)))


@compiled
def gather_disks(
    points: F64, normals: F64, disks: F64, weights: F64, starts: I64,
    cell: float, count: int, reach: float, gems: bool, found: F64,
) -> None:  # fmt: skip
    """Add to ``found`` (n, 2 sides, k) what disks take of the hemispheres before and behind points (n, 3) with unit normals.

    disks: (m, 7) position, unit normal, area, sorted by cell. weights: (m, k) of what each takes, in k guesses. starts: (count^3 + 1,).
    """
    k = weights.shape[1]
    for i in range(len(points)):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        x0, x1 = cell_span(px, reach, cell, count)
        y0, y1 = cell_span(py, reach, cell, count)
        z0, z1 = cell_span(pz, reach, cell, count)
        for x in range(x0, x1 + 1):
            for y in range(y0, y1 + 1):
                row = (x * count + y) * count
                for j in range(starts[row + z0], starts[row + z1 + 1]):
                    dx, dy, dz = disks[j, 0] - px, disks[j, 1] - py, disks[j, 2] - pz
                    r2 = dx * dx + dy * dy + dz * dz
                    if r2 >= reach * reach or r2 == 0.0:
                        continue
                    r = math.sqrt(r2)
                    receiver = (nx * dx + ny * dy + nz * dz) / r
                    emitter = (disks[j, 3] * dx + disks[j, 4] * dy + disks[j, 5] * dz) / r
                    taken = transfer(gems, disks[j, 6], r2, min(abs(receiver), 1.0), min(abs(emitter), 1.0))
                    side = 0 if receiver > 0 else 1
                    for guess in range(k):
                        found[i, side, guess] += taken * weights[j, guess]
