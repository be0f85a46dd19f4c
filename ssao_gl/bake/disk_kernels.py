"""Occlusion by disks, compiled by numba. Importing this needs the package numba.

All sums are in 64-bit and go through the tree in one order: the same bytes on any number of threads.
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
OPENING = 3.5
"""Extents of a branch within which a point looks at what is in it."""
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
def gather_disks(
    points: F64, normals: F64, nodes: F64, extent: F64, skip: I64, weights: F64, reach: float, gems: bool, found: F64,
) -> None:  # fmt: skip
    """Add to ``found`` (n, 2 sides, k + 1) what disks take of the hemispheres before and behind points (n, 3) with unit normals.

    nodes, extent, skip: of a :class:`~.disk_tree.DiskTree`; a branch stands as so many equal disks at one place where it is far enough, and wholly within reach.
    weights: (m, 2 sides, k) of what each takes, in k guesses, of points that it turns its back or its face to. The last column is of the last guess,
    less with distance: ``1 - r / reach``.
    """
    k = weights.shape[2]
    for i in range(len(points)):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        j = 0
        while j < len(skip):
            dx, dy, dz = nodes[j, 0] - px, nodes[j, 1] - py, nodes[j, 2] - pz
            r2 = dx * dx + dy * dy + dz * dz
            r = math.sqrt(r2)
            if skip[j] > j + 1:
                if r - extent[j] >= reach:
                    j = skip[j]
                    continue
                if r < OPENING * extent[j] or r + extent[j] > reach:
                    j += 1
                    continue
            if r < reach and r2 > 0.0:
                receiver = (nx * dx + ny * dy + nz * dz) / r
                emitter = (nodes[j, 3] * dx + nodes[j, 4] * dy + nodes[j, 5] * dz) / r
                taken = nodes[j, 7] * transfer(gems, nodes[j, 6], r2, min(abs(receiver), 1.0), min(abs(emitter), 1.0))
                side = 0 if receiver > 0 else 1
                face = 0 if emitter > 0 else 1
                for guess in range(k):
                    found[i, side, guess] += taken * weights[j, face, guess]
                found[i, side, k] += taken * weights[j, face, k - 1] * (1 - r / reach)
            j = skip[j]
