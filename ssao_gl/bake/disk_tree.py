"""An octree of disks, whose far branches stand as one disk each: Bunnell's hierarchy (GPU Gems 2, 2005, 14.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scene.surface_patches import AREA
from ..scene.z_order import along_z_order

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
LEVELS = 20
"""Of the octree over -1..1: three coordinates of so many bits, and the way a disk faces, fit into 64 bits."""


@dataclass(frozen=True, eq=False)
class DiskTree:
    """Three octrees, one for disks that face along each axis, as one list in which a branch comes before what it holds.

    disks: (m, c) the leaves, sorted; normals point along their axis. nodes: (n, 8) leaves and branches: mean position, mean
    direction, area, and how many disks of it stand for it. extent: (n,) farthest rim of a leaf from the mean position. first, last: (n,) leaves ``first`` to
    before ``last`` are in a node. skip: (n,) the next node that is not inside it.
    """

    disks: F64
    nodes: F64
    extent: F64
    first: I64
    last: I64
    skip: I64

    def means(self, values: F64) -> F64:
        """Return means (n, ...) over each node's leaves of ``values`` (m, ...), by area."""
        area = (self.nodes[:, AREA] * self.nodes[:, AREA + 1]).reshape(-1, *[1] * (values.ndim - 1))
        weighted = values * self.disks[:, AREA].reshape(-1, *[1] * (values.ndim - 1))
        padded = np.concatenate([weighted, np.zeros((1, *values.shape[1:]))])
        return np.asarray(np.add.reduceat(padded, np.stack([self.first, self.last], 1).ravel())[::2] / area)


def disk_tree(disks: F64) -> DiskTree:
    """Sort disks (m, 7 or more) into a tree."""
    way = np.abs(disks[:, 3:6]).argmax(1)
    sign = np.take_along_axis(disks[:, 3:6], way[:, None], 1) < 0
    code = _morton(disks[:, :3]) | way.astype(np.int64) << 3 * LEVELS
    order = np.argsort(code, kind="stable")
    disks, code = disks[order], code[order]
    disks[:, 3:6] *= np.where(sign[order], -1, 1)
    leaves = np.column_stack([disks[:, :7], np.ones(len(disks))])
    levels = [(leaves, np.sqrt(disks[:, AREA] / np.pi), np.arange(len(disks)), np.arange(1, len(disks) + 1))]
    below = np.arange(len(disks))
    for level in range(LEVELS + 1):
        here = code >> 3 * level
        levels.append(_branches(disks, here, below))
        below = here
    nodes, extent, first, last = (np.concatenate(parts) for parts in zip(*levels, strict=True))
    order = np.lexsort((first - last, first))  # the largest of those that begin at a leaf comes first
    first, last = first[order], last[order]
    return DiskTree(disks, nodes[order], extent[order], first, last, np.searchsorted(first, last))


def _branches(disks: F64, here: I64, below: I64) -> tuple[F64, F64, I64, I64]:
    """Nodes, extents and leaves of the branches of one level, but for those with a single branch or leaf below them.

    here, below: (m,) number of the branch that holds each leaf, on this level and on the one below.
    """
    starts = np.flatnonzero(np.diff(here, prepend=-1))
    inner = np.flatnonzero(np.diff(below, prepend=-1))
    many = np.diff(np.searchsorted(inner, np.append(starts, len(here)))) > 1
    first, last = starts[many], np.append(starts[1:], len(here))[many]
    if not len(first):
        return np.zeros((0, 8)), np.zeros(0), first, last
    which = np.flatnonzero(np.repeat(many, np.diff(np.append(starts, len(here)))))
    inside, area = disks[which], disks[which, AREA, None]
    length = last - first
    at = np.cumsum(length) - length
    sums = np.add.reduceat(np.concatenate([inside[:, :6] * area, area], 1), at)
    middle, normal = sums[:, :3] / sums[:, 6:], sums[:, 3:6]
    rim = np.linalg.norm(inside[:, :3] - np.repeat(middle, length, 0), axis=1) + np.sqrt(area[:, 0] / np.pi)
    direction = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    nodes = np.column_stack([middle, direction, sums[:, 6] / 2, np.full(len(first), 2)])
    return nodes, np.maximum.reduceat(rim, at), first, last


def _morton(points: F64) -> I64:
    """(n,) places of points (n, 3) of -1..1 along the Z-order curve."""
    cells = np.clip((points + 1) / 2 * (1 << LEVELS), 0, (1 << LEVELS) - 1).astype(np.uint64)
    return along_z_order(cells).astype(np.int64)
