"""Vertices as places: each stands for the triangles around it, by the share that it has in their interpolated values.

A vertex's value is the mean of occlusion over its fan, weighted by its barycentric coordinate: the projection to piecewise
linear functions with a lumped mass matrix (Kavan, Bargteil & Sloan, "Least Squares Vertex Baking", EGSR 2011, solve the whole
system). So a vertex in a corner shows what is around it, and not the one point that touches the other wall.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..sampling.hemisphere import sobol_points
from ..truth.batches import Points
from ..truth.rays import RayScene
from .facets import Facets
from .primitives import Primitive, chosen_parts

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Fans:
    """Places of vertices that have a fan.

    Corners of triangles, sorted by the place that they belong to: primitive, triangle and corner (0 to 2) of each (c,). reach:
    (c,) number of the place plus the share of its fan up to and with that corner's triangle, by area. places: (n,) of the
    places with an area, as numbers that ``reach`` counts. side: 1 front, -1 back.
    """

    facets: Facets
    primitives: Sequence[Primitive]
    primitive: NDArray[np.int32]
    triangle: I64
    corner: NDArray[np.int8]
    reach: F64
    places: I64
    points_each: int
    seed: int
    side: float = 1.0

    @property
    def rays(self) -> RayScene:
        """What may block."""
        return self.facets.rays

    def __len__(self) -> int:
        return len(self.places)

    @property
    def double_sided(self) -> NDArray[np.bool_]:
        """(n,) of places of materials that are seen from both sides."""
        material = np.array([primitive.double_sided for primitive in self.primitives], bool)
        first = np.searchsorted(self.reach, self.places, "right")
        return material[self.primitive[np.minimum(first, len(self.reach) - 1)]]

    def backs(self, which: NDArray[np.bool_]) -> Fans:
        """Return some of the places (n,), seen from behind."""
        return replace(self, places=self.places[which], side=-self.side)

    def content(self) -> Iterator[NDArray[Any]]:
        """Yield all that decides the points, for a hash."""
        yield from (self.primitive, self.triangle, self.corner, self.reach, self.places, np.array(self.side))
        yield from (np.array(primitive.parts) for primitive in self.primitives)

    def points(self, at: slice) -> Points:
        """Points over the fans, as dense as the vertices' weights are; one of the instances each."""
        places = self.places[at]
        shift = np.random.default_rng([self.seed, at.start, 1]).random((4, len(places)))
        first, last = np.searchsorted(self.reach, [places[0], places[-1] + 1], "right") if len(places) else (0, 0)
        reach = self.reach[first : last + 1]  # of these places: what fits into a core's own cache is searched faster
        found = []
        for one in _lattice(self.points_each, self.seed):
            moved = one[:, None] + shift
            moved -= moved >= 1
            choice, instance, height, along = moved
            entry = first + np.minimum(np.searchsorted(reach, places + choice, "right"), len(reach) - 1)
            # Density of the vertex's own coordinate b: 6 b (1 - b), so its distribution 3 b^2 - 2 b^3, turned round. Such
            # functions of 32-bit floats are far faster, and which point it is does not matter.
            own = 0.5 - np.sin(np.arcsin((1 - 2 * height).astype(np.float32)) / np.float32(3)).astype(np.float64)
            left = (1 - own) * along
            right = 1 - own - left
            corner = self.corner[entry]
            u = np.where(corner == 0, left, np.where(corner == 1, own, right))
            v = np.where(corner == 0, right, np.where(corner == 1, left, own))
            parts = chosen_parts(self.primitives, self.primitive[entry], instance)
            found.append(self.facets.starts(parts, self.triangle[entry], u, v, self.side))
        return found


def fans(facets: Facets, primitives: Sequence[Primitive], points_each: int, seed: int) -> tuple[Fans, list[I64]]:
    """Return the places, and for each primitive (n,) which place a vertex belongs to, -1 where it has no fan.

    Vertices of one mesh at the same position with the same normal are one place: they are apart only for a texture's sake.
    """
    shown = [p for p in primitives if p.parts]
    owners, count = [], 0
    for _, group in groupby(shown, lambda p: p.mesh):
        for numbers in _welded(list(group)):
            owners.append(numbers + count)
        count = max((int(own.max(initial=-1)) + 1 for own in owners), default=0)
    corners = np.concatenate([own[p.faces].ravel() for p, own in zip(shown, owners, strict=True)] or [np.zeros(0, np.int64)])
    area = np.concatenate([np.repeat(facets.areas(p.parts[0], len(p.faces)), 3) for p in shown] or [np.zeros(0)])
    order = np.argsort(corners, kind="stable")
    total = np.bincount(corners, area, count)
    corners, area = corners[order], area[order]
    before = np.concatenate([[0.0], np.cumsum(np.bincount(corners, minlength=count))])[:-1].astype(np.int64)
    sums = np.cumsum(area / np.maximum(total[corners], np.finfo(np.float64).tiny))
    reach = corners + np.clip(sums - np.concatenate([[0.0], sums])[before[corners]], 0, 1)
    ends = np.flatnonzero(np.diff(corners, append=-1))
    reach[ends] = corners[ends] + 1  # whatever was rounded
    kept = np.flatnonzero(total > 0)
    made = Fans(
        facets, shown,
        np.concatenate([np.full(3 * len(p.faces), k, np.int32) for k, p in enumerate(shown)] or [np.zeros(0, np.int32)])[order],
        np.concatenate([np.repeat(np.arange(len(p.faces)), 3) for p in shown] or [np.zeros(0, np.int64)])[order],
        (order % 3).astype(np.int8), reach, kept, points_each, seed,
    )  # fmt: skip
    number = np.full(count + 1, -1)
    number[kept] = np.arange(len(kept))
    by_id = {id(p): number[own] for p, own in zip(shown, owners, strict=True)}
    return made, [by_id.get(id(p), np.full(p.vertices, -1)) for p in primitives]


def _welded(group: Sequence[Primitive]) -> Iterator[I64]:
    """(n,) for each primitive of a mesh: vertices with the same bytes of position and normal have the same number."""
    rows = []
    for primitive in group:
        data = primitive.data
        normals = np.zeros((primitive.vertices, 3)) if data.normals is None else data.normals
        rows.append(np.column_stack([data.vertices, normals]).astype(np.float32) + np.float32(0))  # -0 becomes 0
    every = np.ascontiguousarray(np.concatenate(rows))
    _, numbers = np.unique(every.view(f"V{every.itemsize * 6}").ravel(), return_inverse=True)
    start = 0
    for primitive in group:
        yield numbers[start : start + primitive.vertices].astype(np.int64)
        start += primitive.vertices


def _lattice(count: int, seed: int) -> F64:
    """(count, 4) well spread points in [0, 1): two scrambled Sobol sets side by side."""
    every = 1 << (count - 1).bit_length()
    first, second = (sobol_points(every, seed, 1 << 20 | k) for k in (0, 1))
    return np.column_stack([first, second])[:count]
