"""Surfaces as small patches: triangles cut until they are small, and pieces far smaller than a patch joined."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError

F64 = NDArray[np.float64]
EQUILATERAL = np.sqrt(3) / 4
"""Area of the largest triangle without an edge above 1."""
TINY = 1e-30
"""Area of what is too small to be seen."""
AREA = 6
"""Column of a patch's area, after its position and normal; any after it are its own, weighted by area."""

TIES = (1.0, 1.0001, 1.0002)
"""Weights of edges, so that rounding does not decide which of equal ones is cut."""
DIAGONAL = (1.0, 1.01, 1.02)
"""Weights of axes, so that rounding does not decide for walls that run along a diagonal."""


def cut_triangles(
    pieces: F64, owner: NDArray[np.int32], edge: float, most: int, too_many: str
) -> tuple[F64, NDArray[np.int32]]:
    """Cut triangles (n, 3, 3 or more), position first, at the middle of their longest edge until none is longer than ``edge``.

    Return them and the ``owner`` (n,) of each. Raises SceneError with ``too_many`` for more than ``most``.
    """
    done: list[tuple[F64, NDArray[np.int32]]] = []
    across = np.cross(pieces[:, 1, :3] - pieces[:, 0, :3], pieces[:, 2, :3] - pieces[:, 0, :3])
    least = np.linalg.norm(across, axis=1).sum() / 2 / (EQUILATERAL * edge**2)
    before = 0
    while len(pieces):
        if before + max(2 * len(pieces), least) > most:
            raise SceneError(too_many)
        sides = np.stack([np.linalg.norm(pieces[:, (k + 1) % 3, :3] - pieces[:, k, :3], axis=1) for k in range(3)], 1)
        long = sides.max(1) > edge
        done.append((pieces[~long], owner[~long]))
        pieces, owner, sides = pieces[long], owner[long], sides[long]
        before, least = before + len(done[-1][0]), 0.0
        first = (sides * TIES).argmax(1)
        a, b, c = (np.take_along_axis(pieces, ((first + k) % 3)[:, None, None], 1)[:, 0] for k in range(3))
        middle = (a + b) / 2
        pieces = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        owner = np.concatenate([owner, owner])
    return np.concatenate([pieces, *(one for one, _ in done)]), np.concatenate([owner, *(one for _, one in done)])


def patches_of(pieces: F64) -> tuple[F64, NDArray[np.bool_]]:
    """Return the patches (m, 7) of triangles (n, 3, 3 or more): position, unit normal, area; and which (n,) have an area."""
    a, b, c = pieces[:, 0, :3], pieces[:, 1, :3], pieces[:, 2, :3]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    some = length > TINY
    return np.concatenate([pieces[some, :, :3].mean(1), normal[some] / length[some, None], length[some, None] / 2], 1), some


def joined(patches: F64, side: float) -> F64:
    """Join patches (m, 7 or more) of one cell of so wide a grid that face one way: at their mean place, with what their areas add up to.

    Bunnell's parents, of one level: a dense scan is no dearer than a coarse one. Each of six ways is one axis and its sign.
    """
    way, facing = _ways(patches)
    key = np.column_stack([np.floor(patches[:, :3] / side).astype(np.int64), way * 2 + facing])
    order = np.lexsort(key.T)
    first = np.flatnonzero(np.any(np.diff(key[order], axis=0, prepend=np.iinfo(np.int64).min // 2), axis=1))
    area = patches[order, AREA, None]
    sums = np.add.reduceat(patches[order] * np.where(np.arange(patches.shape[1]) == AREA, 1, area), first)
    across = np.linalg.norm(sums[:, 3:6], axis=1, keepdims=True)
    normals = sums[:, 3:6] / across
    # Layers of a cell hide each other: together they are no more than one through it, or than the largest of them.
    most = np.maximum(side**2 / np.abs(normals).max(1, keepdims=True), np.maximum.reduceat(area, first))
    means = sums / sums[:, AREA, None]
    return np.concatenate([means[:, :3], normals, np.minimum(across, most), means[:, AREA + 1 :]], 1)


def one_way(patches: F64) -> F64:
    """Return patches (m, 7) with normals turned so that both sides of a thin wall face one way."""
    turned = patches.copy()
    turned[:, 3:6] *= np.where(_ways(patches)[1], 1, -1)[:, None]
    return turned


def _ways(patches: F64) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the axis (m,) that each normal is nearest to, and whether it points along it."""
    way = (np.abs(patches[:, 3:6]) * DIAGONAL).argmax(1)
    return way, np.take_along_axis(patches[:, 3:6], way[:, None], 1)[:, 0] > 0
