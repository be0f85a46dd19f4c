"""Transfer functions: which colour and which opacity a value of a volume has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError

TABLE = 256
"""Steps of the table that shaders and rays look values up in."""

MOST_POINTS = 1000


@dataclass(frozen=True, slots=True)
class TransferPoint:
    """A value, its opacity in 0..1 over the unit length, and its sRGB colour in 0..1."""

    value: float
    opacity: float
    color: tuple[float, float, float] = (0.8, 0.8, 0.8)


@dataclass(frozen=True)
class Transfer:
    """Points between which opacity and colour are linear; constant before the first and after the last.

    unit: length in scene units over which the opacities hold, None for the shortest side of a voxel: alpha of a step is
    ``1 - (1 - opacity)^(step / unit)``, so pictures do not depend on the step. step: of the march, in voxels. relative:
    values are shares of the data's range, 0 for the least and 1 for the largest. Raises SceneError.
    """

    points: Sequence[TransferPoint]
    unit: float | None = None
    step: float = 0.5
    relative: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        where = f"transfer function '{self.name}'" if self.name else "transfer function"
        if not 1 <= len(self.points) <= MOST_POINTS:
            raise SceneError(f"{where}: has {len(self.points)} points; expected 1 to {MOST_POINTS}")
        numbers = np.array([[p.value, p.opacity, *p.color] for p in self.points], np.float64)
        if not np.isfinite(numbers).all():
            raise SceneError(f"{where}: its points must be finite numbers")
        if (np.diff(numbers[:, 0]) < 0).any():
            raise SceneError(f"{where}: the values of its points must grow")
        if ((numbers[:, 1:] < 0) | (numbers[:, 1:] > 1)).any():
            raise SceneError(f"{where}: opacities and colours must be 0 to 1")
        if self.unit is not None and not 0 < self.unit < np.inf:
            raise SceneError(f"{where}: unit={self.unit:g}: must be above 0 (scene units)")
        if not 0.05 <= self.step <= 4:
            raise SceneError(f"{where}: step={self.step:g}: must be 0.05 to 4 (voxels)")

    def over(self, low: float, high: float) -> Transfer:
        """Return the same function of values whose least and largest, ``low`` and ``high``, are called 0 and 1."""
        if self.relative:
            return self
        points = [TransferPoint((p.value - low) / (high - low), p.opacity, p.color) for p in self.points]
        return Transfer(points, self.unit, self.step, True, self.name)

    def table(self) -> NDArray[np.float32]:
        """(TABLE, 4) sRGB and opacity at values from 0 to 1; of a relative function."""
        at = np.linspace(0, 1, TABLE)
        values = [p.value for p in self.points]
        columns = [np.interp(at, values, [p.color[i] for p in self.points]) for i in range(3)]
        columns.append(np.interp(at, values, [p.opacity for p in self.points]))
        return np.stack(columns, -1).astype(np.float32)

    def transparent(self, low: NDArray[np.float32], high: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether no value from ``low`` to ``high``, in 0..1, has any opacity; of a relative function."""
        seen = np.concatenate([[0], np.cumsum(self.table()[:, 3] > 0)])
        first, last = (np.clip(v, 0, 1) * np.float32(TABLE - 1) for v in (low, high))
        below, above = np.floor(first).astype(np.int64), np.ceil(last).astype(np.int64)
        return np.asarray(seen[above + 1] == seen[below])

    def opaque(self, values: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether values, in 0..1, have any opacity; of a relative function."""
        return ~self.transparent(values, values)
