"""Rays through a grid of spheres, compiled by numba. Importing this needs the package numba.

The walk is that of Amanatides & Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987). A sphere is in the list of
every cell that its box meets; it is hollow, so that a ray from within meets its inside, as with meshes. All in 64-bit: numba's float() keeps 32.
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
def _inside(o: float, d: float, low: float, high: float, enter: float, leave: float) -> tuple[float, float]:
    """Return which part of a ray, of ``enter`` to ``leave``, lies between two borders; an empty one where none does."""
    if d != 0.0:
        a, b = (low - o) / d, (high - o) / d
        return max(enter, min(a, b)), min(leave, max(a, b))
    return (enter, leave) if low <= o <= high else (1.0, -1.0)


@compiled
def _walk(o: float, d: float, enter: float, low: float, cell: float, count: int) -> tuple[int, int, float, float]:
    """Return the first cell along an axis, its direction, where the ray leaves it, and how far it is from cell to cell."""
    at, step = _clamped((o + enter * d - low) / cell, count), (1 if d > 0.0 else -1)
    if d == 0.0:
        return at, step, math.inf, math.inf
    return at, step, (low + cell * (at + (step > 0)) - o) / d, cell / abs(d)


@compiled
def _met(spheres: F32, s: int, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float) -> float:
    """Return where a ray meets a sphere, in lengths of its direction; infinity where it does not."""
    cx, cy, cz = ox - np.float64(spheres[s, 0]), oy - np.float64(spheres[s, 1]), oz - np.float64(spheres[s, 2])
    r = np.float64(spheres[s, 3])
    length2, half = dx * dx + dy * dy + dz * dz, cx * dx + cy * dy + cz * dz
    inside = half * half - length2 * (cx * cx + cy * cy + cz * cz - r * r)
    if not (inside >= 0.0 and r > 0.0 and length2 > 0.0):
        return math.inf
    root = math.sqrt(inside)
    near = (-half - root) / length2
    return float(near if near > 0.0 else (-half + root) / length2)


@compiled
def first_hits(
    rays: tuple[F32, F32, F32],
    spheres: F32,
    low: float,
    cell: float,
    shape: tuple[int, int, int],
    lists: tuple[I64, NDArray[np.uint32]],
    whole: bool,
    distance: NDArray[np.float64],
    found: I64,
) -> None:
    """Write the distance and the sphere (-1: none) of the first hit of each ray within its reach; any hit unless ``whole``.

    rays: origins, directions (n, 3), reaches (n,). lists: where each cell's begins, and all of them.
    """
    origins, directions, reach = rays
    starts, members = lists
    for ray in range(len(origins)):
        ox, oy, oz = np.float64(origins[ray, 0]), np.float64(origins[ray, 1]), np.float64(origins[ray, 2])
        dx, dy, dz = np.float64(directions[ray, 0]), np.float64(directions[ray, 1]), np.float64(directions[ray, 2])
        best: float = np.float64(reach[ray])
        which = -1
        enter, leave = _inside(ox, dx, low, low + cell * shape[0], 0.0, best)
        enter, leave = _inside(oy, dy, low, low + cell * shape[1], enter, leave)
        enter, leave = _inside(oz, dz, low, low + cell * shape[2], enter, leave)
        x, sx, tx, step_x = _walk(ox, dx, enter, low, cell, shape[0])
        y, sy, ty, step_y = _walk(oy, dy, enter, low, cell, shape[1])
        z, sz, tz, step_z = _walk(oz, dz, enter, low, cell, shape[2])
        while enter <= leave and 0 <= x < shape[0] and 0 <= y < shape[1] and 0 <= z < shape[2]:
            at = (x * shape[1] + y) * shape[2] + z
            for k in range(starts[at], starts[at + 1]):
                t = _met(spheres, members[k], ox, oy, oz, dx, dy, dz)
                if 0.0 < t < best:
                    best, which = t, int(members[k])
            border = min(tx, ty, tz)
            if border >= min(best, leave) or (which >= 0 and not whole):
                break
            if tx == border:
                x, tx = x + sx, tx + step_x
            elif ty == border:
                y, ty = y + sy, ty + step_y
            else:
                z, tz = z + sz, tz + step_z
        distance[ray] = best
        found[ray] = which
