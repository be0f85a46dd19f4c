"""What has been traced so far: sums over batches, for blocks of pixels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]

BLOCK = 1 << 13
"""Pixels traced together: their directions stay in a core's own cache. Results depend on it."""


def blocks(count: int, length: int = BLOCK) -> Iterator[slice]:
    """Slices of ``length`` that cover ``count`` items."""
    return (slice(start, min(start + length, count)) for start in range(0, count, length))


@dataclass(frozen=True, slots=True, eq=False)
class PartialSums:
    """One block: batches done, and sum and sum of squares of their means (n,) float64."""

    batches: int
    total: F64
    squares: F64

    def plus(self, means: F64) -> PartialSums:
        """With one more batch."""
        return PartialSums(self.batches + 1, self.total + means, self.squares + means**2)


@dataclass(eq=False)
class Sums:
    """All blocks. One is replaced by a whole new one in a single step, so an interrupt never finds half an update."""

    parts: list[PartialSums]
    seconds: float = 0.0

    @classmethod
    def empty(cls, count: int) -> Sums:
        """Nothing traced yet, for ``count`` pixels."""
        return cls([PartialSums(0, np.zeros(at.stop - at.start), np.zeros(at.stop - at.start)) for at in blocks(count)])

    @classmethod
    def restored(cls, saved: Mapping[str, Any]) -> Sums:
        """Return what :meth:`saved` gave."""
        places = blocks(len(saved["total"]))
        parts = [
            PartialSums(int(n), saved["total"][at], saved["squares"][at])
            for n, at in zip(saved["batches"], places, strict=True)
        ]
        return cls(parts, float(saved["seconds"]))

    def saved(self) -> dict[str, Any]:
        """As arrays, for :meth:`restored`."""
        parts = list(self.parts)
        return {
            "batches": np.array([part.batches for part in parts]),
            "total": np.concatenate([part.total for part in parts]),
            "squares": np.concatenate([part.squares for part in parts]),
            "seconds": self.seconds,
        }

    @property
    def batches(self) -> int:
        """Batches that every block has."""
        return min((part.batches for part in self.parts), default=0)

    def estimate(self) -> tuple[F64, F64]:
        """Mean and its standard error (n,) when all blocks have as many batches.

        ``sqrt((mean of squares - square of mean) / (batches - 1))``, unbiased in its square. One batch has no spread;
        then 1/2, the most that the deviation of values in 0..1 can be.
        """
        if not self.parts:
            return np.zeros(0), np.zeros(0)
        n = self.batches
        mean = np.concatenate([part.total for part in self.parts]) / n
        if n == 1:
            return mean, np.full_like(mean, 0.5)
        squares = np.concatenate([part.squares for part in self.parts]) / n
        return mean, np.sqrt(np.maximum(squares - mean**2, 0) / (n - 1))


def rms(values: NDArray[np.floating]) -> float:
    """Root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64)))) if values.size else 0.0
