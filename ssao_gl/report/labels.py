"""Where to put the names of points in a plot so that none covers another. Pixels, y upwards."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

Place = tuple[float, float]

GAP = 7.0
"""Between a point and its name, and half the side of a point's mark, pixels."""


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-parallel rectangle."""

    x0: float
    y0: float
    x1: float
    y1: float

    def overlap(self, other: Box) -> float:
        """Area that two boxes share."""
        return max(0.0, min(self.x1, other.x1) - max(self.x0, other.x0)) * max(
            0.0, min(self.y1, other.y1) - max(self.y0, other.y0)
        )

    def within(self, other: Box) -> bool:
        return self.x0 >= other.x0 and self.y0 >= other.y0 and self.x1 <= other.x1 and self.y1 <= other.y1


def spread(points: Sequence[Place], sizes: Sequence[Place], frame: Box) -> list[Place]:
    """The lower left corner of a name of each size (w, h) beside each point, inside the frame.

    Greedy: points that have others near choose first; each takes the nearest place that covers no mark and no name,
    and where there is none the one that covers least.
    """
    marks = [Box(x - GAP / 2, y - GAP / 2, x + GAP / 2, y + GAP / 2) for x, y in points]
    crowd = [sum(math.dist(p, q) < 60 for q in points) for p in points]
    taken: dict[int, Box] = {}
    for index in sorted(range(len(points)), key=lambda i: (-crowd[i], points[i][1])):
        others = [box for i, box in enumerate(marks) if i != index] + list(taken.values())
        options = [box for box in _around(points[index], sizes[index]) if box.within(frame)]
        options = options or [next(_around(points[index], sizes[index]))]
        # The first that covers nothing; min takes the earliest, and so nearest, of equals.
        taken[index] = min(options, key=lambda box: sum(box.overlap(other) for other in others))
    return [(taken[i].x0, taken[i].y0) for i in range(len(points))]


def _around(point: Place, size: Place) -> Iterator[Box]:
    """Places for a name, nearest first: right, left, above, below, then on growing rings."""
    (x, y), (w, h) = point, size
    for ring in range(1, 9):
        far = GAP * ring
        for angle in (0, 180, 90, 270, 45, 315, 135, 225, 20, 340, 160, 200, 70, 110, 250, 290):
            c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            cx, cy = x + c * (far + w / 2), y + s * (far + h / 2)
            yield Box(cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2)
