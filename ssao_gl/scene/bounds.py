"""Boxes around what is drawn: exact ones, and the box of a scene without strays, for automatic cameras and radii."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .model import Mesh

Box = NDArray[np.float64]
"""(2, 3): smallest and largest coordinate."""
Points = NDArray[np.float64]


class Drawable(Protocol):
    """What a scene draws, once for each of its transforms (k, 4, 4): model-to-world."""

    @property
    def transforms(self) -> Points: ...

    @property
    def bounds(self) -> Box:
        """Box of all instances in the world."""

    @property
    def is_placed(self) -> bool:
        """Whether it has something to draw, and a place."""

    @property
    def can_show(self) -> bool:
        """Whether something of it may be seen."""

    @property
    def piece_count(self) -> int:
        """Of what may lie apart from the rest by itself, in one instance."""

    def outline(self) -> NDArray[np.float32]:
        """Return points (n, 3) of it in the model, some of each piece."""

    def pieces(self, matrix: Points) -> tuple[Points, Points]:
        """Return boxes (n, 2, 3) in the world and areas (n,) of the pieces of an instance."""


BUDGET = 1 << 27
"""Vertices times different turns of one mesh up to which each is looked at; beyond it the corners of its own box are."""
CHUNK = 1 << 18

STRAY_AREA = 1e-3
"""Share of a scene's area that its strays may have together."""
STRAY_GAP = 2e-3
"""Share of a scene's extent along an axis that must be empty between a stray and the rest. What is closer changes nothing much."""
BINS = 1024
PASSES = 24
MAX_PIECES = 1 << 22
"""Triangles or spheres, instances counted each, that are looked at for strays one by one; of larger scenes, instances are."""


def placed_bounds(points: NDArray[np.float32], transforms: Points, radii: NDArray[np.float32] | None = None) -> Box:
    """Return the box in the world of all instances of points (n, 3), or of spheres about them under similarities."""
    reach = np.zeros(1, np.float32) if radii is None else radii[:, None]
    low, high = (points - reach).min(0).astype(np.float64), (points + reach).max(0).astype(np.float64)
    corners = box_corners(low, high)
    linear, offset = transforms[:, :3, :3], transforms[:, :3, 3]
    # An axis that follows one of the model's has its extremes at the corners of the model's box.
    straight = (np.count_nonzero(linear, axis=2) <= 1).all(1)
    boxes = [_extremes(np.einsum("kij,cj->kci", transforms[straight, :3], np.column_stack([corners, np.ones(8)])))]
    turned, which = np.unique(linear[~straight].reshape(-1, 9), axis=0, return_inverse=True)
    if len(turned):
        whole = len(turned) * len(points) <= BUDGET
        chosen, around = (points, radii) if whole else (corners.astype(np.float32), None)
        spans = np.array([_span(chosen, matrix.reshape(3, 3), around) for matrix in turned])
        boxes.append(_extremes(spans[which.ravel()] + offset[~straight][:, None]))
    found = np.stack([box for box in boxes if np.isfinite(box).all()])
    return np.stack([found[:, 0].min(0), found[:, 1].max(0)])


def _extremes(points: Points) -> Box:
    """Return the box of (k, c, 3) points; of infinities when there are none."""
    flat = points.reshape(-1, 3)
    return np.stack([flat.min(0, initial=np.inf), flat.max(0, initial=-np.inf)])


def _span(points: NDArray[np.float32], matrix: Points, radii: NDArray[np.float32] | None) -> Box:
    boxes = []
    for start in range(0, len(points), CHUNK):
        part = slice(start, start + CHUNK)
        placed = points[part].astype(np.float64) @ matrix.T
        if radii is None:
            boxes.append(_extremes(placed))
        else:
            reach = radii[part, None] * similarity_scale(matrix)
            boxes.append(np.stack([(placed - reach).min(0), (placed + reach).max(0)]))
    return _extremes(np.stack(boxes))


def similarity_scale(matrix: Points) -> float:
    """Return the factor by which a similarity (3 or 4, 3 or 4) enlarges."""
    return float(np.linalg.norm(matrix[:3, 0]))


def named_positions(mesh: Mesh) -> NDArray[np.float32]:
    """Return positions (n, 3) without those that no triangle names; all where every one is named."""
    named = np.zeros(len(mesh.positions), bool)
    named[mesh.triangles.ravel()] = True
    return mesh.positions if named.all() else mesh.positions[named]


def box_corners(low: Points, high: Points) -> Points:
    """Return the eight corners (8, 3) of a box."""
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], np.float64)


def core_bounds(drawn: Sequence[Drawable], whole: Box) -> Box:
    """Return the box of a scene without its strays: tiny things far from all the rest, which are hardly seen.

    A stray lies beyond an empty gap along some axis; all together have no more than a thousandth of the area. ``whole`` is
    the box of everything, and what comes back when there are none.
    """
    if not _has_gaps(drawn, whole):
        return whole
    boxes, areas = (np.concatenate(parts) for parts in zip(*_pieces(drawn), strict=True))
    left = STRAY_AREA * areas.sum()
    if not left > 0:
        return whole
    core = whole
    for _ in range(PASSES):
        found = _cut(boxes, areas, core, left)
        if found is None:
            break
        kept, core = found
        left -= areas[~kept].sum()
        boxes, areas = boxes[kept], areas[kept]
    return core


def _cut(boxes: Points, areas: Points, core: Box, left: float) -> tuple[NDArray[np.bool_], Box] | None:
    """Cut one end of one axis off at a gap: return which pieces (n,) stay, and their box; None without such a gap."""
    for axis in range(3):
        low, high = core[:, axis]
        if not high > low:
            continue
        scale = BINS / (high - low)
        ends = np.clip((boxes[:, :, axis] - low) * scale, 0, BINS - 1).astype(np.int64)
        cover = np.zeros(BINS + 1, np.int64)
        np.add.at(cover, ends[:, 0], 1)
        np.add.at(cover, ends[:, 1] + 1, -1)
        empty = np.cumsum(cover[:-1]) == 0
        for end in (1, 0):
            middle = ends[:, 0] if end else ends[:, 1]
            weight = np.bincount(middle, areas, BINS)
            outer = np.cumsum(weight[::-1])[::-1] if end else np.cumsum(weight)
            gaps = _runs(empty)
            for first, last in gaps if end else reversed(gaps):
                beyond = outer[min(last, BINS - 1)] if end else outer[first]
                if last - first >= STRAY_GAP * BINS and beyond <= left:
                    kept = ends[:, 1] < first if end else ends[:, 0] >= last
                    if kept.any() and not kept.all():
                        return kept, np.stack([boxes[kept, 0].min(0), boxes[kept, 1].max(0)])
    return None


def _runs(empty: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return runs [first, last) of empty bins."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], empty, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _has_gaps(drawn: Sequence[Drawable], whole: Box) -> bool:
    """Tell whether some bin along some axis holds no point: without, nothing lies apart, and the pieces need no look."""
    size = whole[1] - whole[0]
    if not (np.isfinite(size).all() and size.max() > 0):
        return False
    scale = BINS / np.where(size > 0, size, np.inf)
    seen = np.zeros((3, BINS), bool)
    for thing in drawn:
        if thing.piece_count * len(thing.transforms) > MAX_PIECES:
            return True
        points = thing.outline()
        for matrix in thing.transforms:
            for start in range(0, len(points), CHUNK):
                world = points[start : start + CHUNK].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
                bins = np.clip((world - whole[0]) * scale, 0, BINS - 1).astype(np.int64)
                for axis in range(3):
                    seen[axis, bins[:, axis]] = True
        if seen[size > 0].all():
            return False
    return True


def _pieces(drawn: Sequence[Drawable]) -> Iterator[tuple[Points, Points]]:
    """Return boxes (n, 2, 3) and areas (n,) of all pieces in the world, or of whole instances where they are too many."""
    many = sum(thing.piece_count * len(thing.transforms) for thing in drawn) > MAX_PIECES
    for thing in drawn:
        if many:
            boxes, areas = thing.pieces(np.eye(4))
            corners = np.column_stack([box_corners(boxes[:, 0].min(0), boxes[:, 1].max(0)), np.ones(8)])
            placed = np.einsum("kij,cj->kci", thing.transforms[:, :3], corners)
            scale = np.abs(np.linalg.det(thing.transforms[:, :3, :3])) ** (2 / 3)
            yield np.stack([placed.min(1), placed.max(1)], 1), areas.sum() * scale
        else:
            for matrix in thing.transforms:
                yield thing.pieces(matrix)


def triangle_pieces(mesh: Mesh, matrix: Points) -> tuple[Points, Points]:
    """Return boxes (n, 2, 3) and areas (n,) of a mesh's triangles in the world."""
    world = mesh.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    a, b, c = (world[mesh.triangles[:, k]] for k in range(3))
    boxes = np.stack([np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)], 1)
    return boxes, np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
