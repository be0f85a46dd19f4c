"""Small statistics, and values as JSON holds them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def quartiles(values: Sequence[float]) -> list[float]:
    """[lower quartile, median, upper quartile]."""
    return [float(q) for q in np.percentile(values, (25, 50, 75))]


def mean(values: Sequence[float | None]) -> float | None:
    """Arithmetic mean of what is there; None of nothing."""
    there = [value for value in values if value is not None]
    return float(np.mean(there)) if there else None


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float | None:
    """Return the ``b`` of ``time = a size^b`` by least squares of logarithms; None of fewer than two sizes."""
    if len(set(sizes)) < 2:
        return None
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
