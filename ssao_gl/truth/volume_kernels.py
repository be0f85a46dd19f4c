"""Rays through the trilinear field of a volume, compiled by numba: what ``lib/trilinear.glsl`` and its kin do, in 64-bit.

Importing this needs the package numba. All kernels are in one file: numba's cache knows no changes of others. Coordinates are
those of ``Volume.field``, whose order is (z, y, x). A cell's coefficients ``k`` are those of 1, x, y, z, yz, xz, xy, xyz with
x, y, z in 0..1. Arrays that end in ``_`` are room to write into.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..scene.proximity import INSIDE
from .blockers import F32, F64

I64 = NDArray[np.int64]
Grid = tuple[F32, NDArray[np.uint8], I64]
"""A field for rays: (z, y, x); how far they may leap in each cell (see :mod:`..scene.proximity`); and the box (2, 3) of cells
that holds all there is to see."""
Medium = tuple[F32, float]
"""What a transfer function makes of a field: opacities (n,) over the unit length, of values at equal steps from 0 to 1; and the
step of the march in voxels."""

SEEN, FINER = 0.5, 0.125
"""Light that is left along a ray where a surface is seen; shortening of the step in which that is."""
DARK = 1e-3
"""Light below which a ray counts as blocked."""
CLEAR = 0.01
"""Opacity over the unit length below which a point counts as outside of the material that its surface is made of."""
LIFT, MOST_LIFTS = 0.5, 6
"""Rays start outside of the material that their surface is made of: up to six steps of half a voxel off it."""

compiled = njit(nogil=True, cache=True, error_model="numpy")


@compiled
def load_cell(field: F32, x: int, y: int, z: int, k_: F64) -> None:
    """Write the coefficients of cell (x, y, z)."""
    for corner in range(8):
        k_[corner] = field[z + corner // 4, y + corner // 2 % 2, x + corner % 2]
    a, b, c, d, e, f, g, h = k_
    k_[0], k_[1], k_[2], k_[3] = a, b - a, c - a, e - a
    k_[4], k_[5], k_[6] = (g - e) - (c - a), (f - e) - (b - a), (d - c) - (b - a)
    k_[7] = ((h - g) - (f - e)) - ((d - c) - (b - a))


@compiled
def value(k: F64, x: float, y: float, z: float) -> Any:
    """Return the field at a place (x, y, z) of a cell."""
    return k[0] + k[1] * x + k[2] * y + k[3] * z + k[4] * y * z + k[5] * x * z + k[6] * x * y + k[7] * x * y * z


@compiled
def value_at(field: F32, x: float, y: float, z: float, k_: F64) -> Any:
    """Return the field at any point; beyond its ends, what it is there."""
    cx = min(max(math.floor(x), 0), field.shape[2] - 2)
    cy = min(max(math.floor(y), 0), field.shape[1] - 2)
    cz = min(max(math.floor(z), 0), field.shape[0] - 2)
    load_cell(field, cx, cy, cz, k_)
    return value(k_, min(max(x - cx, 0.0), 1.0), min(max(y - cy, 0.0), 1.0), min(max(z - cz, 0.0), 1.0))


@compiled
def smooth_gradient(field: F32, p: F64, k_: F64, out_: F64) -> None:
    """Write central differences at a point."""
    for axis in range(3):
        hx, hy, hz = 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)
        ahead = value_at(field, p[0] + hx, p[1] + hy, p[2] + hz, k_)
        out_[axis] = 0.5 * (ahead - value_at(field, p[0] - hx, p[1] - hy, p[2] - hz, k_))


@compiled
def cell_gradient(k: F64, x: float, y: float, z: float, out_: F64) -> None:
    """Write the gradient at a place of a cell."""
    out_[0] = k[1] + k[6] * y + k[5] * z + k[7] * y * z
    out_[1] = k[2] + k[6] * x + k[4] * z + k[7] * x * z
    out_[2] = k[3] + k[5] * x + k[4] * y + k[7] * x * y


@compiled
def cubic(k: F64, q: F64, e: F64, c_: F64) -> None:
    """Write the coefficients of 1, u, u^2, u^3 of the field along q + u e."""
    c_[0] = value(k, q[0], q[1], q[2])
    cell_gradient(k, q[0], q[1], q[2], c_[1:])
    c_[1] = c_[1] * e[0] + c_[2] * e[1] + c_[3] * e[2]
    yz, xz, xy = e[1] * e[2], e[0] * e[2], e[0] * e[1]
    c_[2] = k[4] * yz + k[5] * xz + k[6] * xy + k[7] * (q[0] * yz + q[1] * xz + q[2] * xy)
    c_[3] = k[7] * e[0] * e[1] * e[2]


@compiled
def at(c: F64, u: float) -> Any:
    """Return a cubic's value."""
    return ((c[3] * u + c[2]) * u + c[1]) * u + c[0]


@compiled
def first_root(c: F64) -> Any:
    """Return where in 0..1 a cubic first changes from its side of 0 at 0 to the other; -1 if it does not (Marmitt et al. 2004)."""
    inside = c[0] >= 0
    first = second = 1.0
    root2 = c[2] * c[2] - 3 * c[3] * c[1]
    if root2 > 0:
        q = -(c[2] + math.copysign(math.sqrt(root2), c[2]))
        a = q / (3 * c[3]) if abs(3 * c[3]) * 1e12 > abs(q) else 1.0
        b = c[1] / q if q != 0 else 1.0
        first, second = min(max(min(a, b), 0.0), 1.0), min(max(max(a, b), 0.0), 1.0)
    low = 0.0
    for high in (first, second, 1.0):
        if (at(c, high) >= 0) != inside:
            for _ in range(60):  # halved to the last bit
                middle = 0.5 * (low + high)
                if not low < middle < high:
                    break
                if (at(c, middle) >= 0) == inside:
                    low = middle
                else:
                    high = middle
            return low
        low = high
    return -1.0


@compiled
def enter(o: F64, d: F64, box: I64, near: float, far: float) -> tuple[float, float]:
    """Return the part of a ray that lies in a box of cells (2, 3); the end before the start where none does."""
    for axis in range(3):
        slope = d[axis] if d[axis] != 0 else 1e-300
        a, b = (box[0, axis] - o[axis]) / slope, (box[1, axis] - o[axis]) / slope
        near, far = max(near, min(a, b)), min(far, max(a, b))
    return near, far


@compiled
def step_out(grid: Grid, o: F64, d: F64, s: float, last: float, cell_: I64) -> Any:
    """Go from a cell to the next one beyond it and what is like it; return where, ``last`` when the box or the ray ends there.

    Amanatides & Woo 1987: the axis along which a ray leaves decides by whole numbers, so rounding never leads back.
    """
    _, leaps, box = grid
    reach = max(int(leaps[cell_[2], cell_[1], cell_[0]]) % INSIDE - 1, 0)
    leaves = np.inf
    for axis in range(3):
        if d[axis] != 0:
            plane = cell_[axis] + reach + 1 if d[axis] > 0 else cell_[axis] - reach
            leaves = min(leaves, (plane - o[axis]) / d[axis])
    leaves = max(leaves, s)
    if leaves >= last:
        return last
    for axis in range(3):
        low, high = cell_[axis] - reach, cell_[axis] + reach
        plane = high + 1 if d[axis] > 0 else low
        if d[axis] != 0 and (plane - o[axis]) / d[axis] <= leaves:
            cell_[axis] = high + 1 if d[axis] > 0 else low - 1
        else:
            cell_[axis] = min(max(math.floor(o[axis] + leaves * d[axis]), low), high)
        if not box[0, axis] <= cell_[axis] < box[1, axis]:
            return last
    return leaves


@compiled
def start_cell(o: F64, d: F64, box: I64, s: float, cell_: I64) -> None:
    """Write the cell of a ray's point."""
    for axis in range(3):
        cell_[axis] = min(max(math.floor(o[axis] + s * d[axis]), box[0, axis]), box[1, axis] - 1)


@compiled
def surface_hit(grid: Grid, o: F64, d: F64, reach: float, cell_: I64, room_: F64) -> Any:
    """Return how far along a ray the field first changes sides of 0, -1 where it does not within ``reach``; its cell is in ``cell_``."""
    field, leaps, box = grid
    k_, q_, e_, c_ = room_[0], room_[1], room_[2], room_[3]
    s, last = enter(o, d, box, 0.0, reach)
    if not last > s:
        return -1.0
    start_cell(o, d, box, s, cell_)
    inside = value_at(field, o[0] + s * d[0], o[1] + s * d[1], o[2] + s * d[2], k_) >= 0
    while s < last:
        leap = leaps[cell_[2], cell_[1], cell_[0]]
        if leap % INSIDE > 0:
            if (leap >= INSIDE) != inside:
                return s
            s = step_out(grid, o, d, s, last, cell_)
            continue
        x, y, z = cell_
        load_cell(field, x, y, z, k_)
        after = step_out(grid, o, d, s, last, cell_)
        for axis, low in enumerate((x, y, z)):
            q_[axis] = min(max(o[axis] + s * d[axis] - low, 0.0), 1.0)
            e_[axis] = (after - s) * d[axis]
        cubic(k_, q_, e_, c_)
        u = 0.0 if (c_[0] >= 0) != inside else first_root(c_)
        if u >= 0:
            cell_[0], cell_[1], cell_[2] = x, y, z
            return s + u * (after - s)
        s = after
    return -1.0


@compiled
def surface_distances(grid: Grid, origins: F64, directions: F64, reach: F32, cells_: I64, out_: F64) -> None:
    """Write how far each ray (n, 3), in the field's coordinates, goes to the surface, -1 for none; and the cells (n, 3) where."""
    room = np.empty((4, 8))
    for ray in range(len(origins)):
        out_[ray] = surface_hit(grid, origins[ray], directions[ray], np.float64(reach[ray]), cells_[ray], room)


@compiled
def gradients(field: F32, points: F64, cells: I64, exact_: F64, smooth_: F64, values_: F64) -> None:
    """Write the field's own gradients at points (n, 3) of cells, those of central differences, and its values."""
    k = np.empty(8)
    for i in range(len(points)):
        x, y, z = cells[i]
        load_cell(field, x, y, z, k)
        for axis in range(3):
            smooth_[i, axis] = min(max(points[i, axis] - cells[i, axis], 0.0), 1.0)
        px, py, pz = smooth_[i]
        cell_gradient(k, px, py, pz, exact_[i])
        values_[i] = value(k, px, py, pz)
        smooth_gradient(field, points[i], k, smooth_[i])


@compiled
def opacity_of(table: F32, v: float) -> Any:
    """Return the opacity over the unit length of a value in 0..1; ``table`` (n,): opacities at equal steps."""
    place = min(max(v, 0.0), 1.0) * (len(table) - 1)
    below = min(int(place), len(table) - 2)
    part = place - below
    return (1 - part) * table[below] + part * table[below + 1]


@compiled
def march(
    grid: Grid, medium: Medium, o: F64, d: F64, reach: float, unit: float, stop: float, cell_: I64, k_: F64
) -> tuple[float, float]:
    """Return the light that is left along a ray, and where it falls to ``stop``, -1 where it stays above.

    unit: length along the ray that opacities hold over. Light that falls to ``stop`` ends the march; where the step in which
    it does is to be known finely, it is taken again in shorter ones.
    """
    field, leaps, box = grid
    table, step = medium
    step /= math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    finer = FINER if stop >= SEEN else 1.0
    near, last = enter(o, d, box, 0.0, reach)
    light = 1.0
    if not last > near:
        return light, -1.0
    start_cell(o, d, box, near, cell_)
    s = near
    while s < last:
        if leaps[cell_[2], cell_[1], cell_[0]] % INSIDE > 0:
            s = step_out(grid, o, d, s, last, cell_)
            continue
        end = min(max((math.floor(s / step) + 1) * step, s + 1e-3 * step), last)
        m = 0.5 * (s + end)
        alpha = opacity_of(table, value_at(field, o[0] + m * d[0], o[1] + m * d[1], o[2] + m * d[2], k_))
        if alpha > 0:
            after = light * (1 - alpha) ** ((end - s) / unit) if alpha < 1 else 0.0
            if after <= stop and finer < 1:
                step, finer = step * finer, 1.0
                continue
            if after <= stop:
                part = unit * math.log(stop / light) / math.log(1 - alpha) if alpha < 1 else 0.0
                return after, s + min(max(part, 0.0), end - s)
            light = after
        s = end
        start_cell(o, d, box, s, cell_)
    return light, -1.0


@compiled
def seen_distances(
    grid: Grid, medium: Medium, origins: F64, directions: F64, reach: F32, units: F64, cells_: I64, out_: F64
) -> None:
    """Write how far each ray (n, 3) goes until half of its light is left, -1 where more is; and the cells where."""
    k = np.empty(8)
    for ray in range(len(origins)):
        o, d = origins[ray], directions[ray]
        _, out_[ray] = march(grid, medium, o, d, np.float64(reach[ray]), units[ray], SEEN, cells_[ray], k)
        if out_[ray] >= 0:
            start_cell(o, d, grid[2], out_[ray], cells_[ray])


@compiled
def opacities(
    grid: Grid, medium: Medium, origins: F64, directions: F64, reach: float, units: F64, away: F64, out_: F32
) -> None:
    """Write the opacity (n,) along each ray from outside of the material that it starts in. ``away`` (3, 3): from gradients to
    directions across surfaces."""
    k, g, p = np.empty(8), np.empty(3), np.empty(3)
    cell = np.empty(3, np.int64)
    for ray in range(len(origins)):
        lift(grid[0], medium[0], origins[ray], away, k, g, p)
        light, _ = march(grid, medium, p, directions[ray], reach, units[ray], DARK, cell, k)
        out_[ray] = 1 - light


@compiled
def lift(field: F32, table: F32, o: F64, away: F64, k_: F64, g_: F64, p_: F64) -> None:
    """Write the nearest point across the surface at ``o``, to the side of less opacity, that lies outside of its material."""
    smooth_gradient(field, o, k_, g_)
    for axis in range(3):
        p_[axis] = away[axis, 0] * g_[0] + away[axis, 1] * g_[1] + away[axis, 2] * g_[2]
    size = LIFT / max(math.sqrt(p_[0] * p_[0] + p_[1] * p_[1] + p_[2] * p_[2]), 1e-300)
    x, y, z = size * p_[0], size * p_[1], size * p_[2]
    up = opacity_of(table, value_at(field, o[0] + x, o[1] + y, o[2] + z, k_))
    down = opacity_of(table, value_at(field, o[0] - x, o[1] - y, o[2] - z, k_))
    for n in range(MOST_LIFTS + 1):
        for side in (-n, n):  # both, while opacity is level and does not tell
            if (side < 0 and up < down) or (side > 0 and down < up):
                continue
            p_[0], p_[1], p_[2] = o[0] + side * x, o[1] + side * y, o[2] + side * z
            if opacity_of(table, value_at(field, p_[0], p_[1], p_[2], k_)) < CLEAR:
                return
