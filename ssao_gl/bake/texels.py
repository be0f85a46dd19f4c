"""Texels as places: each stands for what of the surface lies in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..truth.batches import Points
from ..truth.rays import RayScene
from .facets import Facets
from .primitives import Primitive, chosen_parts

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
FINE = 2
"""Points of a texel along each of its sides."""
PAIRS = 1 << 21
"""Triangles times points that are looked at in a step."""
INSIDE = 1e-3
"""Barycentric coordinate from which a point is inside a triangle, and not on an edge that another shares."""


@dataclass(frozen=True, eq=False)
class TextureLayout:
    """Triangles of several primitives in one texture.

    uv: (m, 3, 2) of all of them, v downwards. first: number of the first triangle of each primitive, and of all after the
    last one.
    """

    primitives: Sequence[Primitive]
    uv: F32
    first: I64

    @classmethod
    def of(cls, primitives: Sequence[Primitive], coordinates: Sequence[F32], faces: Sequence[I64]) -> TextureLayout:
        """Join primitives: their texture coordinates (n, 2) and triangles (m, 3)."""
        uv = np.concatenate([uv[f] for uv, f in zip(coordinates, faces, strict=True)]).astype(np.float32)
        return cls(primitives, uv, np.concatenate([[0], np.cumsum([len(f) for f in faces])]))

    @property
    def fits(self) -> bool:
        """Whether all coordinates lie in the picture."""
        return bool(np.isfinite(self.uv).all() and self.uv.min(initial=0) >= -1e-5 and self.uv.max(initial=0) <= 1 + 1e-5)


@dataclass(frozen=True, eq=False)
class TexelPlaces:
    """Places of the texels of a square texture that show something.

    owner: (FINE * size, FINE * size) int32, the triangle of ``layout`` at each point, -1 for none. places: (n,) numbers of
    the texels, row by row from the top. side: 1 front, -1 back.
    """

    facets: Facets
    layout: TextureLayout
    owner: NDArray[np.int32]
    places: I64
    seed: int
    side: float = 1.0

    @property
    def rays(self) -> RayScene:
        """What may block."""
        return self.facets.rays

    def __len__(self) -> int:
        return len(self.places)

    @property
    def size(self) -> int:
        """Texels along each side."""
        return len(self.owner) // FINE

    @property
    def double_sided(self) -> NDArray[np.bool_]:
        """(n,) of texels whose first point is on a material that is seen from both sides."""
        material = np.array([primitive.double_sided for primitive in self.layout.primitives], bool)
        return material[self._primitive(self._owners(self.places)[0][0])]

    def backs(self, which: NDArray[np.bool_]) -> TexelPlaces:
        """Return some of the places (n,), seen from behind."""
        return replace(self, places=self.places[which], side=-self.side)

    def content(self) -> Iterator[NDArray[Any]]:
        """Yield all that decides the points, for a hash."""
        yield from (self.layout.uv, self.layout.first, self.owner, self.places, np.array(self.side))
        yield from (np.array(primitive.parts) for primitive in self.layout.primitives)

    def points(self, at: slice) -> Points:
        """Points on a grid in each texel, on what is there; one of the instances each."""
        places = self.places[at]
        shift = np.random.default_rng([self.seed, at.start, 2]).random(len(places))
        found = []
        for number, (triangle, x, y) in enumerate(self._owners(places)):
            primitive = self._primitive(triangle)
            parts = chosen_parts(self.layout.primitives, primitive, (shift + number / FINE**2) % 1)
            b = _barycentric(self.layout.uv[triangle].astype(np.float64) * len(self.owner), x + 0.5, y + 0.5)
            b = np.clip(np.nan_to_num(b, nan=1 / 3), 0, None)
            b /= b.sum(0)
            found.append(self.facets.starts(parts, triangle - self.layout.first[primitive], b[1], b[2], self.side))
        return found

    def _primitive(self, triangle: I64) -> I64:
        return np.searchsorted(self.layout.first, triangle, "right") - 1

    def _owners(self, places: I64) -> list[tuple[I64, I64, I64]]:
        """Triangle, column and row of each point of the texels; where a point shows nothing, another one's."""
        row, column = np.divmod(places, self.size)
        grid = np.arange(FINE**2)
        y, x = row[:, None] * FINE + grid // FINE, column[:, None] * FINE + grid % FINE
        owner = self.owner[y, x].astype(np.int64)
        turn = (grid[:, None] + grid) % FINE**2  # at its own point first, then at those after it
        taken = turn[np.arange(FINE**2), (owner[:, turn] >= 0).argmax(2)]
        n = np.arange(len(places))[:, None]
        return list(zip(owner[n, taken].T, x[n, taken].T, y[n, taken].T, strict=True))


def texels(facets: Facets, layout: TextureLayout, size: int, seed: int) -> tuple[TexelPlaces, float]:
    """Return the places of a texture of ``size`` texels a side, and which share of its points two triangles claim."""
    side = FINE * size
    owner = np.full(side * side, -1, np.int32)
    inside = np.zeros(side * side, bool)
    claims = 0
    for triangle, point, deep in _covered(layout.uv.astype(np.float64) * side, side):
        owner[point[::-1]] = triangle[::-1]  # the first one stays
        claims += int(deep.sum())
        inside[point[deep]] = True
    _add_slivers(layout, owner, side)
    covered = (owner.reshape(size, FINE, size, FINE) >= 0).any((1, 3))
    claimed = int(inside.sum())
    share = (claims - claimed) / max(claimed, 1)
    return TexelPlaces(facets, layout, owner.reshape(side, side), np.flatnonzero(covered), seed), share


def _covered(uv: F64, side: int) -> Iterator[tuple[NDArray[np.int32], I64, NDArray[np.bool_]]]:
    """(triangle, point, whether well inside) for points of a grid in triangles (m, 3, 2) given in its units."""
    low = np.clip(np.ceil(np.nan_to_num(uv.min(1)) - 0.5), 0, side).astype(np.int64)
    high = np.clip(np.floor(np.nan_to_num(uv.max(1)) - 0.5), -1, side - 1).astype(np.int64)
    width, height = np.maximum(high - low + 1, 0).T
    owner = np.repeat(np.arange(len(uv)), np.where(width > 0, height, 0))  # of each row of points
    row = low[owner, 1] + _counted(height[width > 0])
    end = np.cumsum(width[owner])
    start = 0
    while start < len(owner):
        before = end[start - 1] if start else 0
        stop = max(int(np.searchsorted(end, before + PAIRS, "right")), start + 1)
        rows, many = owner[start:stop], width[owner[start:stop]]
        triangle, y = np.repeat(rows, many), np.repeat(row[start:stop], many)
        x = low[triangle, 0] + _counted(many)
        least = _barycentric(uv[triangle], x + 0.5, y + 0.5).min(0)
        hit = least >= -1e-9
        yield triangle[hit].astype(np.int32), (y * side + x)[hit], least[hit] > INSIDE
        start = stop


def _counted(many: I64) -> I64:
    """0, 1, ... for each of some lengths (n,), one after another."""
    return np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)


def _barycentric(uv: F64, x: NDArray[np.floating], y: NDArray[np.floating]) -> F64:
    """(3, n) coordinates of points in triangles (n, 3, 2); nan in those without an area."""
    (ax, ay), (bx, by), (cx, cy) = (uv[:, k].T for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
        c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    return np.stack([1 - b - c, b, c])


def _add_slivers(layout: TextureLayout, owner: NDArray[np.int32], side: int) -> None:
    """Let triangles that cover no point of the grid have the one next to their middle, where that is free."""
    shown = np.zeros(len(layout.uv), bool)
    shown[owner[owner >= 0]] = True
    lost = np.flatnonzero(~shown)
    middle = np.clip(np.nan_to_num(layout.uv[lost].mean(1)) * side, 0, side - 1).astype(np.int64)
    point = middle[:, 1] * side + middle[:, 0]
    free = owner[point] < 0
    owner[point[free][::-1]] = lost[free][::-1]
