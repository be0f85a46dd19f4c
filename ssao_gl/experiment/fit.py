"""Three scalars that make the most of a method: a radius factor, a strength and a power. Pure arithmetic.

Visibility comes in 256 levels, so what a mapping of levels does to the error follows exactly from three sums over the
pixels of each level: their number, the sum of the truth there, and the sum of its squares. No image is kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
LEVELS = 256

FACTORS = (0.35, 0.5, 0.71, 1.0, 1.41, 2.0, 2.83)
"""Radius factors that are tried: every half octave."""

STRENGTHS, POWERS = (0.1, 8.0), (0.25, 4.0)
"""Bounds of the search."""

GRID, REFINEMENTS, NEAR = 33, 9, 6
"""Points a side, finer grids, and half the width of each in steps of the one before: wide, since strength and power can
stand in for each other and the valley between them is narrow and curved."""


@dataclass(frozen=True, slots=True)
class Scalars:
    """A fit: the radius times ``radius``, then ``A' = clamp(1 - strength (1 - A), 0, 1)^power``."""

    radius: float = 1.0
    strength: float = 1.0
    power: float = 1.0

    @property
    def key(self) -> str:
        """As text: rows measured under one fit are not those of another."""
        return f"{self.radius:.4g} {self.strength:.6g} {self.power:.6g}"

    def __call__(self, visibility: NDArray[Any]) -> NDArray[Any]:
        """Visibility of any shape after strength and power."""
        return np.asarray(np.clip(1 - self.strength * (1 - visibility), 0, 1) ** self.power)


@dataclass(frozen=True, eq=False, slots=True)
class Levels:
    """Sums over the pixels of each level of visibility, (256,) float64: number, truth, truth squared."""

    count: F64
    total: F64
    squares: F64

    @classmethod
    def of(cls, visibility: NDArray[Any], truth: NDArray[Any], where: NDArray[np.bool_]) -> Levels:
        """Of a visibility image in 0..1 and its truth, both (h, w), over some pixels."""
        level = np.round(visibility[where] * (LEVELS - 1)).astype(np.int64)
        t = truth[where].astype(np.float64)
        return cls(*(np.bincount(level, weights, LEVELS).astype(np.float64) for weights in (None, t, t**2)))

    @classmethod
    def loaded(cls, sums: Sequence[Sequence[float]]) -> Levels:
        """Return what :meth:`saved` gave."""
        return cls(*(np.asarray(row, np.float64) for row in sums))

    def saved(self) -> list[list[float]]:
        """As lists, for JSON."""
        return [[float(f"{value:.9g}") for value in row] for row in (self.count, self.total, self.squares)]

    def rmse(self, mapped: F64) -> F64:
        """RMSE when level ``i`` becomes ``mapped[..., i]``; of no pixels 0."""
        squares = mapped**2 @ self.count - 2 * mapped @ self.total + self.squares.sum()
        return np.asarray(np.sqrt(np.maximum(squares, 0) / max(self.count.sum(), 1)))


def fit(tried: Mapping[float, Sequence[Levels]]) -> tuple[Scalars, float]:
    """Return the scalars with the smallest mean RMSE over views, and that mean. ``tried``: radius factor -> Levels of every
    view."""
    found = [(*_strength_and_power(views), factor) for factor, views in tried.items()]
    strength, power, error, factor = min(found, key=lambda one: one[2])
    return Scalars(factor, strength, power), error


def _strength_and_power(views: Sequence[Levels]) -> tuple[float, float, float]:
    """(strength, power, mean RMSE): a grid in logarithms, then finer ones about its best point."""
    bounds = np.log([STRENGTHS, POWERS])
    low, high = bounds.T
    open_ = 1 - np.arange(LEVELS) / (LEVELS - 1)
    best = (1.0, 1.0, np.inf)
    for _ in range(REFINEMENTS):
        strength, power = (np.exp(np.linspace(low[i], high[i], GRID)) for i in (0, 1))
        base = np.clip(1 - strength[:, None] * open_, 0, 1)
        mapped = base[:, None, :] ** power[None, :, None]
        error = np.mean([view.rmse(mapped) for view in views], 0)
        k, p = np.unravel_index(int(np.argmin(error)), error.shape)
        if error[k, p] < best[2]:
            best = (float(strength[k]), float(power[p]), float(error[k, p]))
        step = NEAR * (high - low) / (GRID - 1)
        middle = np.log(best[:2])
        low, high = np.clip([middle - step, middle + step], *bounds.T)
    return best
