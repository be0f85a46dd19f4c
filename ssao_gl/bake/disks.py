"""A scene's triangles as disks: each cut until it is small, each piece a disk of its area."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Mesh
from ..scene.surface_patches import cut_triangles, joined, patches_of
from ..scene.texels import alpha_at, colors_at
from ..truth.rays import RayScene

F64 = NDArray[np.float64]
MOST_DISKS = 8_000_000


def disks_of(rays: RayScene, edge: float, *, colored: bool = False) -> F64:
    """Return disks (m, 7) of triangles whose edges are at most ``edge`` local units, joined where they are far smaller.

    Their position, unit normal and area; ``colored``: and linear base colour (m, 10). Raises SceneError for too many.
    """
    too_many = (
        f"{rays.scene.name or 'the scene'} has more than {MOST_DISKS:,} elements at a fourth of the radius; take a larger radius,"
        " or bake by rays"
    )
    found = [np.zeros((0, 10 if colored else 7))]
    for mesh, corners, owner in _parts(rays):
        pieces, owner = cut_triangles(corners, owner, edge, MOST_DISKS - sum(map(len, found)), too_many)
        if mesh.cutoff is not None:
            u, v = pieces[:, :, 3:].mean(1).T
            solid = alpha_at(mesh, owner, u, v) >= mesh.cutoff
            pieces, owner = pieces[solid], owner[solid]
        patches, some = patches_of(pieces)
        columns = [patches]
        if colored:
            columns.append(colors_at(mesh, owner[some], *pieces[some, :, 3:].mean(1).T))
        found.append(np.concatenate(columns, 1))
    return joined(np.concatenate(found), edge / 3)


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
