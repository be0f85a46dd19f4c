"""A scene's triangles as disks: each cut until it is small, each piece a disk of its area."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.model import Mesh
from ..scene.texels import alpha_at, colors_at
from ..truth.rays import RayScene

F64 = NDArray[np.float64]
MOST_DISKS = 8_000_000
TINY = 1e-30
"""Area of what is too small to be seen."""
EQUILATERAL = np.sqrt(3) / 4
"""Area of the largest triangle without an edge above 1."""
AREA = 6
"""Column of a disk's area; those after it are its colour, linear, where somebody wants it."""


def disks_of(rays: RayScene, edge: float, *, colored: bool = False) -> F64:
    """Return disks (m, 7) of triangles whose edges are at most ``edge`` local units, joined where they are far smaller.

    Their position, unit normal and area; ``colored``: and linear base colour (m, 10). Raises SceneError for too many.
    """
    found = [np.zeros((0, 10 if colored else 7))]
    for mesh, corners, owner in _parts(rays):
        pieces, owner = _cut(corners, owner, edge, sum(map(len, found)), rays)
        if mesh.cutoff is not None:
            u, v = pieces[:, :, 3:].mean(1).T
            solid = alpha_at(mesh, owner, u, v) >= mesh.cutoff
            pieces, owner = pieces[solid], owner[solid]
        a, b, c = pieces[:, 0, :3], pieces[:, 1, :3], pieces[:, 2, :3]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        some = length > TINY
        columns = [pieces[some, :, :3].mean(1), normal[some] / length[some, None], length[some, None] / 2]
        if colored:
            columns.append(colors_at(mesh, owner[some], *pieces[some, :, 3:].mean(1).T))
        found.append(np.concatenate(columns, 1))
    return _joined(np.concatenate(found), edge / 3)


def _joined(disks: F64, side: float) -> F64:
    """Join disks (m, 7 or 10) of one cell of so wide a grid that face one way: at their mean place, with what their areas add up to.

    Bunnell's parents, of one level: a dense scan is no dearer than a coarse one. Each of six ways is one axis and its sign.
    """
    way = np.abs(disks[:, 3:6]).argmax(1)
    facing = np.take_along_axis(disks[:, 3:6], way[:, None], 1)[:, 0] > 0
    key = np.column_stack([np.floor(disks[:, :3] / side).astype(np.int64), way * 2 + facing])
    order = np.lexsort(key.T)
    first = np.flatnonzero(np.any(np.diff(key[order], axis=0, prepend=np.iinfo(np.int64).min // 2), axis=1))
    area = disks[order, AREA, None]
    sums = np.add.reduceat(disks[order] * np.where(np.arange(disks.shape[1]) == AREA, 1, area), first)
    across = np.linalg.norm(sums[:, 3:6], axis=1, keepdims=True)
    normals = sums[:, 3:6] / across
    # Layers of a cell hide each other: together they are no more than one through it, or than the largest of them.
    most = np.maximum(side**2 / np.abs(normals).max(1, keepdims=True), np.maximum.reduceat(area, first))
    means = sums / sums[:, AREA, None]
    return np.concatenate([means[:, :3], normals, np.minimum(across, most), means[:, AREA + 1 :]], 1)


def _parts(rays: RayScene) -> Iterator[tuple[Mesh, F64, NDArray[np.int32]]]:
    """Every part: its mesh, corners (n, 3, 5) with local position and barycentric u, v, and the triangle of each."""
    number = 0
    bary = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    for mesh in (thing for thing in rays.scene.drawn if isinstance(thing, Mesh)):
        for _ in range(len(mesh.transforms)):
            owner = np.arange(len(mesh.triangles), dtype=np.int32)
            corners, _normals = rays.triangles.corners(number, owner)
            yield mesh, np.concatenate([corners, np.broadcast_to(bary, (len(corners), 3, 2))], 2), owner
            number += 1


def _cut(pieces: F64, owner: NDArray[np.int32], edge: float, before: int, rays: RayScene) -> tuple[F64, NDArray[np.int32]]:
    """Cut triangles (n, 3, 5) at the middle of their longest edge until none is longer than ``edge``."""
    done: list[tuple[F64, NDArray[np.int32]]] = []
    across = np.cross(pieces[:, 1, :3] - pieces[:, 0, :3], pieces[:, 2, :3] - pieces[:, 0, :3])
    least = np.linalg.norm(across, axis=1).sum() / 2 / (EQUILATERAL * edge**2)
    while len(pieces):
        if before + max(2 * len(pieces), least) > MOST_DISKS:
            raise SceneError(
                f"{rays.scene.name or 'the scene'} has more than {MOST_DISKS:,} elements at a fourth of the radius; take a larger radius,"
                " or bake by rays"
            )
        sides = np.stack([np.linalg.norm(pieces[:, (k + 1) % 3, :3] - pieces[:, k, :3], axis=1) for k in range(3)], 1)
        long = sides.max(1) > edge
        done.append((pieces[~long], owner[~long]))
        pieces, owner, sides = pieces[long], owner[long], sides[long]
        before, least = before + len(done[-1][0]), 0.0
        first = sides.argmax(1)
        a, b, c = (np.take_along_axis(pieces, ((first + k) % 3)[:, None, None], 1)[:, 0] for k in range(3))
        middle = (a + b) / 2
        pieces = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        owner = np.concatenate([owner, owner])
    return np.concatenate([one for one, _ in done]), np.concatenate([one for _, one in done])
