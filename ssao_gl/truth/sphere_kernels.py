"""Rays through a grid of spheres, compiled by numba. Importing this needs the package numba.

The walk is that of Amanatides & Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987). A sphere is in the list of
every cell that its box meets; it is hollow, so that a ray from within meets its inside, as with meshes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., object])
F32 = NDArray[np.float32]
I64 = NDArray[np.int64]
compiled = cast(Callable[[Function], Function], njit(nogil=True, cache=True))


@compiled
def count_cells(spheres: F32, low: float, cell: float, shape: tuple[int, int, int], starts: I64) -> None:
    """Add to ``starts`` (cells + 1,), one place further on, how many of ``spheres`` (n, 4) meet each cell."""
    for s in range(len(spheres)):
        x0, x1, y0, y1, z0, z1 = _span(spheres, s, low, cell, shape)
        for x in range(x0, x1 + 1):
            for y in range(y0, y1 + 1):
                for z in range(z0, z1 + 1):
                    starts[(x * shape[1] + y) * shape[2] + z + 1] += 1


@compiled
def fill_cells(
    spheres: F32, low: float, cell: float, shape: tuple[int, int, int], ends: I64, members: NDArray[np.uint32]
) -> None:
    """Write the numbers of spheres into ``members``; ``ends`` (cells,) says where each cell begins, and then where it ends."""
    for s in range(len(spheres)):
        x0, x1, y0, y1, z0, z1 = _span(spheres, s, low, cell, shape)
        for x in range(x0, x1 + 1):
            for y in range(y0, y1 + 1):
                for z in range(z0, z1 + 1):
                    at = (x * shape[1] + y) * shape[2] + z
                    members[ends[at]] = s
                    ends[at] += 1


@compiled
def _span(spheres: F32, s: int, low: float, cell: float, shape: tuple[int, int, int]) -> tuple[int, int, int, int, int, int]:
    """First and last cell of a sphere along each axis; a little more, for what rounding does to rays along a border."""
    r = spheres[s, 3] * 1.00001 + 1e-6 * cell
    x, y, z = spheres[s, 0] - low, spheres[s, 1] - low, spheres[s, 2] - low
    return (
        _clamped((x - r) / cell, shape[0]),
        _clamped((x + r) / cell, shape[0]),
        _clamped((y - r) / cell, shape[1]),
        _clamped((y + r) / cell, shape[1]),
        _clamped((z - r) / cell, shape[2]),
        _clamped((z + r) / cell, shape[2]),
    )


@compiled
def _clamped(at: float, count: int) -> int:
    return min(max(math.floor(at), 0), count - 1)


@compiled
def first_hits(
    origins: F32,
    directions: F32,
    reach: F32,
    spheres: F32,
    low: float,
    cell: float,
    shape: tuple[int, int, int],
    starts: I64,
    members: NDArray[np.uint32],
    whole: bool,
    distance: NDArray[np.float64],
    found: I64,
) -> None:
    """Write the distance and the sphere (-1: none) of the first hit of each ray within ``reach``; any hit unless ``whole``."""
    inf = math.inf
    for ray in range(len(origins)):
        ox, oy, oz = float(origins[ray, 0]), float(origins[ray, 1]), float(origins[ray, 2])
        dx, dy, dz = float(directions[ray, 0]), float(directions[ray, 1]), float(directions[ray, 2])
        best, which = float(reach[ray]), -1
        # Where the ray is in the grid's box at all.
        enter, leave = 0.0, best
        for axis in range(3):
            o, d = (ox, dx) if axis == 0 else ((oy, dy) if axis == 1 else (oz, dz))
            high = low + cell * shape[axis]
            if d != 0.0:
                a, b = (low - o) / d, (high - o) / d
                enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
            elif o < low or o > high:
                leave = -1.0
        length2 = dx * dx + dy * dy + dz * dz
        if enter <= leave and length2 > 0.0:
            x = _clamped((ox + enter * dx - low) / cell, shape[0])
            y = _clamped((oy + enter * dy - low) / cell, shape[1])
            z = _clamped((oz + enter * dz - low) / cell, shape[2])
            sx, sy, sz = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1), (1 if dz > 0.0 else -1)
            tx = (low + cell * (x + (sx > 0)) - ox) / dx if dx != 0.0 else inf
            ty = (low + cell * (y + (sy > 0)) - oy) / dy if dy != 0.0 else inf
            tz = (low + cell * (z + (sz > 0)) - oz) / dz if dz != 0.0 else inf
            step_x = cell / abs(dx) if dx != 0.0 else inf
            step_y = cell / abs(dy) if dy != 0.0 else inf
            step_z = cell / abs(dz) if dz != 0.0 else inf
            while True:
                at = (x * shape[1] + y) * shape[2] + z
                for k in range(starts[at], starts[at + 1]):
                    s = members[k]
                    cx, cy, cz = ox - spheres[s, 0], oy - spheres[s, 1], oz - spheres[s, 2]
                    r = float(spheres[s, 3])
                    half = cx * dx + cy * dy + cz * dz
                    inside = half * half - length2 * (cx * cx + cy * cy + cz * cz - r * r)
                    if inside >= 0.0 and r > 0.0:
                        root = math.sqrt(inside)
                        t = (-half - root) / length2
                        if t <= 0.0:
                            t = (-half + root) / length2
                        if 0.0 < t < best:
                            best, which = t, int(s)
                border = min(tx, ty, tz)
                if border >= min(best, leave) or (which >= 0 and not whole):
                    break
                if tx == border:
                    x, tx = x + sx, tx + step_x
                elif ty == border:
                    y, ty = y + sy, ty + step_y
                else:
                    z, tz = z + sz, tz + step_z
                if x < 0 or y < 0 or z < 0 or x >= shape[0] or y >= shape[1] or z >= shape[2]:
                    break
        distance[ray] = best
        found[ray] = which
