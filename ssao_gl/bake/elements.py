"""A scene as disks that shade each other: Bunnell, "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2 (2005), chapter 14.

Every triangle is cut until it is small against the radius, and each piece stands as a disk of its area. Disks add up what they take of
a point's hemisphere, so two behind each other darken twice; therefore what a disk takes is weighted by what the pass before found open
before and behind it, in the mean: of any number of close layers the two outer ones count half, the others nothing. The last two passes,
of which one is too dark and the other too bright, are averaged.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, SettingsError
from ..scene.model import Mesh
from ..scene.texels import alpha_at
from ..truth.batches import Places, local_radius
from ..truth.blockers import threads
from ..truth.rays import RayScene
from .settings import Baking

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
EDGE = 1 / 4
"""Longest edge of a disk's triangle, radii: larger disks are seen as disks."""
MOST_DISKS = 8_000_000
EQUILATERAL = np.sqrt(3) / 4
"""Area of the largest triangle without an edge above 1."""
MOST_CELLS = 256
"""Of the grid, along an axis."""
BLOCK = 1 << 12
"""Points gathered by a thread at a time."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Disks of a scene in local units, in the cells of a grid over -1..1.

    disks: (m, 7) position, unit normal, area, sorted by cell. weights: (m, k) of what they take, after each of the last k passes but the
    points' own. starts: (count^3 + 1,) where each cell begins. reach: the radius. gems: see
    :func:`.disk_kernels.transfer`.
    """

    disks: F64
    weights: F64
    starts: I64
    cell: float
    count: int
    reach: float
    gems: bool
    seconds: float = 0.0
    """Spent making them and their passes."""

    def occlusion(self, points: NDArray[Any], normals: NDArray[Any]) -> F64:
        """Return what is taken (n, 2, k) of the hemispheres before and behind points (n, 3), by each of k guesses, at most 1."""
        from .disk_kernels import gather_disks

        points, normals = np.asarray(points, np.float64), np.asarray(normals, np.float64)
        found = np.zeros((len(points), 2, self.weights.shape[1]))

        def gather(start: int) -> None:
            at = slice(start, start + BLOCK)
            grid = self.cell, self.count
            gather_disks(
                points[at], normals[at], self.disks, self.weights, self.starts, *grid, self.reach, self.gems, found[at]
            )

        with ThreadPoolExecutor(threads()) as pool:
            list(pool.map(gather, range(0, len(points), BLOCK)))
        return np.asarray(np.minimum(found, 1))


def elements(rays: RayScene, settings: Baking) -> Elements:
    """Return a scene's disks, and what each counts after ``settings.passes``. Raises SettingsError, SceneError."""
    try:
        import numba  # noqa: F401
    except ImportError:
        raise SettingsError("baking by elements needs the package numba: pip install 'ssao_gl[truth-spheres]'") from None
    started = time.perf_counter()
    reach = local_radius(rays, settings)
    disks = disks_of(rays, EDGE * reach)
    cell = max(reach / 2, 2 / MOST_CELLS)
    count = int(np.ceil(2 / cell)) + 1
    at = np.clip(np.floor((disks[:, :3] + 1) / cell), 0, count - 1).astype(np.int64)
    number = (at[:, 0] * count + at[:, 1]) * count + at[:, 2]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(count**3 + 1))
    disks = disks[order]
    made = Elements(disks, np.ones((len(disks), 1)), starts, cell, count, reach, settings.kernel == "gems")
    passes = [made.weights]
    for _ in range(settings.passes - 1):
        taken = replace(made, weights=passes[-1]).occlusion(disks[:, :3], disks[:, 3:6])
        passes.append(1 - taken.mean(1))
    return replace(made, weights=np.concatenate(passes[-2:], 1), seconds=time.perf_counter() - started)


def visibility_by_elements(places: Places, made: Elements) -> tuple[F64, float]:
    """Return visibility (n,) of places, the mean over their points and the last two passes, and the seconds that it took."""
    started = time.perf_counter()
    every = []
    for start in range(0, len(places), 1 << 16):
        points = places.points(slice(start, min(start + (1 << 16), len(places))))
        every.append(sum(made.occlusion(*one)[:, 0].mean(1) for one in points) / len(points))
    return 1 - np.concatenate(every or [np.zeros(0)]), time.perf_counter() - started


def disks_of(rays: RayScene, edge: float) -> F64:
    """Return disks (m, 7) of triangles whose edges are at most ``edge`` local units, joined where they are far smaller.

    Raises SceneError for too many.
    """
    found = [np.zeros((0, 7))]
    for mesh, corners, owner in _parts(rays):
        pieces, owner = _cut(corners, owner, edge, sum(map(len, found)), rays)
        if mesh.cutoff is not None:
            u, v = pieces[:, :, 3:].mean(1).T
            solid = alpha_at(mesh, owner, u, v) >= mesh.cutoff
            pieces = pieces[solid]
        a, b, c = pieces[:, 0, :3], pieces[:, 1, :3], pieces[:, 2, :3]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        some = length > 0
        columns = [pieces[some, :, :3].mean(1), normal[some] / length[some, None], length[some, None] / 2]
        found.append(np.concatenate(columns, 1))
    return _joined(np.concatenate(found), edge / 3)


def _joined(disks: F64, side: float) -> F64:
    """Join disks (m, 7) of one cell of so wide a grid that face one way: at their mean place, with what their areas add up to.

    Bunnell's parents, of one level: a dense scan is no dearer than a coarse one. Each of six ways is one axis and its sign.
    """
    way = np.abs(disks[:, 3:6]).argmax(1)
    facing = np.take_along_axis(disks[:, 3:6], way[:, None], 1)[:, 0] > 0
    key = np.column_stack([np.floor(disks[:, :3] / side).astype(np.int64), way * 2 + facing])
    order = np.lexsort(key.T)
    first = np.flatnonzero(np.any(np.diff(key[order], axis=0, prepend=np.iinfo(np.int64).min // 2), axis=1))
    area = disks[order, 6:]
    sums = np.add.reduceat(np.concatenate([disks[order, :6] * area, area], 1), first)
    across = np.linalg.norm(sums[:, 3:6], axis=1, keepdims=True)
    normals = sums[:, 3:6] / across
    # Layers of a cell hide each other: together they are no more than one through it, or than the largest of them.
    most = np.maximum(side**2 / np.abs(normals).max(1, keepdims=True), np.maximum.reduceat(area, first))
    return np.concatenate([sums[:, :3] / sums[:, 6:], normals, np.minimum(across, most)], 1)


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
