"""A scene as disks that shade each other: Bunnell, "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2 (2005), chapter 14.

Every triangle is cut until it is small against the radius, and each piece stands as a disk of its area. Disks add up what they take of
a point's hemisphere, so two behind each other darken twice; therefore each pass weighs what a disk takes by what the one before found open
around it. Of layers close to each other, which only the last is open behind, only the last counts; a disk that is alone within reach on
one of its sides counts in full, for what shades its other side may be out of reach of the point. The last two passes, of which one is too
dark and the other too bright, are averaged.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..scene.surface_patches import AREA
from ..truth.batches import Places, local_radius
from ..truth.blockers import threads
from ..truth.rays import RayScene
from .disk_tree import DiskTree, disk_tree
from .disks import disks_of
from .settings import Baking

F64 = NDArray[np.float64]
EDGE = 1 / 4
"""Longest edge of a disk's triangle, radii: larger disks are seen as disks."""
LARGEST_EDGE = 1 / 32
"""The same of endless radii, in local units."""
BLOCK = 1 << 12
"""Points gathered by a thread at a time."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Disks of a scene in local units.

    weights: (n nodes of the tree, 2, k) of what each takes from points that it turns its back to, and its face: after each of the last
    passes but the points' own, and, behind these, its light (r, g, b) where the points want it. reach: the radius. gems: see
    :func:`.disk_kernels.transfer`.
    """

    tree: DiskTree
    weights: F64
    guesses: int
    reach: float
    gems: bool
    seconds: float = 0.0
    """Spent making them and their passes."""

    def gather(self, points: NDArray[Any], normals: NDArray[Any]) -> F64:
        """Return what arrives (n, 2, k + 1) at the hemispheres before and behind points (n, 3), by each column of the weights; see
        :func:`.disk_kernels.gather_disks` for the last one."""
        from .disk_kernels import gather_disks

        points, normals, tree = np.asarray(points, np.float64), np.asarray(normals, np.float64), self.tree
        found = np.zeros((len(points), 2, self.weights.shape[2] + 1))

        def gather(start: int) -> None:
            at = slice(start, start + BLOCK)
            gather_disks(
                points[at], normals[at], tree.nodes, tree.extent, tree.skip, self.weights, self.reach, self.gems, found[at]
            )

        with ThreadPoolExecutor(threads()) as pool:
            list(pool.map(gather, range(0, len(points), BLOCK)))
        return found

    def light(self, points: NDArray[Any], normals: NDArray[Any]) -> F64:
        """Return what is open (n, 1) of the hemispheres before points (n, 3), and, where it is known, the light that disks send (n, 1 + 3)."""
        found = self.gather(points, normals)[:, 0, :-1]
        taken = np.minimum(found[:, : self.guesses], 1).mean(1, keepdims=True)
        return np.concatenate([1 - taken, found[:, self.guesses :]], 1)


def elements(rays: RayScene, settings: Baking) -> Elements:
    """Return a scene's disks, and what each counts after ``settings.passes``. Raises SettingsError, SceneError."""
    try:
        import numba  # noqa: F401
    except ImportError:
        raise SettingsError("baking by elements needs the package numba: pip install 'ssao_gl[truth-spheres]'") from None
    started = time.perf_counter()
    reach = local_radius(rays, settings)
    tree = disk_tree(disks_of(rays, min(EDGE * reach, LARGEST_EDGE), colored=settings.indirect))
    made = Elements(tree, np.ones((len(tree.nodes), 2, 1)), 1, reach, settings.kernel == "gems")
    passes = [made.weights]
    for _ in range(settings.passes - 1):
        found = replace(made, weights=passes[-1]).gather(tree.disks[:, :3], tree.disks[:, 3:6])
        passes.append(tree.means(1 - _hidden(np.minimum(found, 1))))
    weights = passes[-2:]
    if settings.indirect:
        weights = [*weights, tree.means(_sent(replace(made, weights=passes[-1])))]
    return replace(
        made, weights=np.concatenate(weights, 2), guesses=min(settings.passes, 2), seconds=time.perf_counter() - started
    )


def _hidden(found: F64) -> F64:
    """Share (m, 2, 1) of disks that others hide from points behind them and before them; found: as gathered, at most 1.

    A point behind a disk, which turns its back to it, knows the disk hidden by what is close before it.
    """
    return np.asarray(np.maximum(found[:, :, 1:], found[:, :, :1].min(1, keepdims=True)))


def _sent(last: Elements) -> F64:
    """Light (m, 2, 3) that disks send behind them and before them: of a sky of 1, what reaches that side, times their colour and weight."""
    disks = last.tree.disks
    found = last.gather(disks[:, :3], disks[:, 3:6])
    weight = 1 - _hidden(np.minimum(found, 1))
    lit = (1 - np.minimum(found[:, ::-1, :1], 1)) * disks[:, None, AREA + 1 :]
    return np.asarray(weight * lit)


def light_by_elements(places: Places, made: Elements) -> tuple[F64, float]:
    """Return visibility (n, 1), and light that disks send (n, 1 + 3), of places, the mean over their points; and the seconds that it took."""
    started = time.perf_counter()
    every = [np.zeros((0, 1 + made.weights.shape[2] - made.guesses))]
    for start in range(0, len(places), 1 << 16):
        points = places.points(slice(start, min(start + (1 << 16), len(places))))
        every.append(np.sum([made.light(*one) for one in points], axis=0) / len(points))
    return np.concatenate(every), time.perf_counter() - started
