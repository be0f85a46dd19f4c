"""What a cloud of points (time, error) says: the front, its hypervolume, the best at equal time and at equal error."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

Point = tuple[float, float]
"""(time, error), both the smaller the better."""


def front(points: Sequence[Point]) -> list[bool]:
    """Whether each point is on the Pareto front: none other is as good in both and better in one."""
    return [
        not any(t <= time and e <= error and (t < time or e < error) for t, e in points)
        for time, error in points
    ]  # fmt: skip


def hypervolume(points: Iterable[Point], times: tuple[float, float], worst: float) -> float:
    """Share of the box ``log(times[0] .. times[1])`` x ``0 .. worst`` that is dominated by the points, 0 to 1.

    The larger the better; it grows when any point of the front moves to less time or less error. (Zitzler, Thiele,
    "Multiobjective Evolutionary Algorithms", IEEE TEC 1999; time counts by its logarithm.)
    """
    low, high = math.log(times[0]), math.log(times[1])
    if not (high > low and worst > 0):
        return 0.0
    area, until = 0.0, high
    inside = [(max(math.log(t), low), e) for t, e in points if t > 0 and math.log(t) < high and e < worst]
    # From the slowest to the fastest: between two times the best error so far holds.
    for time, _ in sorted(set(inside), reverse=True):
        best = min(e for t, e in inside if t <= time)
        area += (until - time) * (worst - best)
        until = time
    return area / ((high - low) * worst)


def at_time(points: Iterable[Point], budget: float) -> float | None:
    """Return the smallest error within a time, or None."""
    return min((error for time, error in points if time <= budget), default=None)


def at_error(points: Iterable[Point], limit: float) -> float | None:
    """Return the shortest time within an error, or None."""
    return min((time for time, error in points if error <= limit), default=None)
