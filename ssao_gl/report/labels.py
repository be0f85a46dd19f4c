"""Where to put the names of points in a plot so that none covers another. Pixels, y upwards."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

F64 = NDArray[np.float64]

GAP = 7.0
"""Between a point and its name, and the side of a point's mark, pixels."""

STEP = 4.0
"""Between the boxes that stand for a line, pixels."""

ANGLES = np.radians((0, 180, 90, 270, 45, 315, 135, 225, 20, 340, 160, 200, 70, 110, 250, 290))
"""Directions in which a name may lie from its point, the preferred first."""

RINGS, CROWD = 8, 60.0


def place_labels(points: ArrayLike, sizes: ArrayLike, frame: Sequence[float], lines: Sequence[ArrayLike] = ()) -> F64:
    """Lower left corners (n, 2) of names of ``sizes`` (n, 2) beside ``points`` (n, 2), inside ``frame`` (x0, y0, x1, y1).

    Greedy: points that have others near choose first; each takes the nearest place that covers no mark, no name and none
    of the ``lines`` (k, 2), and where there is none the one that covers least.
    """
    at, size = np.asarray(points, np.float64), np.asarray(sizes, np.float64)
    marks = np.concatenate([at - GAP / 2, at + GAP / 2], 1)
    fixed = np.concatenate([marks, *(_along(np.asarray(line, np.float64)) for line in lines)])
    crowd = (np.linalg.norm(at[:, None] - at[None], axis=-1) < CROWD).sum(1)
    taken = np.zeros((len(at), 4))
    for index in sorted(range(len(at)), key=lambda i: (-crowd[i], at[i, 1])):
        options = _around(at[index], size[index])
        inside = (options[:, :2] >= frame[:2]).all(1) & (options[:, 2:] <= frame[2:]).all(1)
        options = options[inside] if inside.any() else options[:1]
        others = np.concatenate([np.delete(fixed, index, 0), taken])
        # argmin takes the earliest, and so nearest, of equals.
        taken[index] = options[int(np.argmin(overlap(options, others).sum(1)))]
    return taken[:, :2]


def overlap(some: F64, others: F64) -> F64:
    """Areas (n, m) that boxes (n, 4) and boxes (m, 4) share; a box is (x0, y0, x1, y1)."""
    low = np.maximum(some[:, None, :2], others[None, :, :2])
    high = np.minimum(some[:, None, 2:], others[None, :, 2:])
    return np.asarray(np.maximum(high - low, 0).prod(-1))


def _along(line: F64) -> F64:
    """Return a line (k, 2) as a row of small boxes (n, 4)."""
    parts = [np.linspace(a, b, max(1, math.ceil(np.linalg.norm(b - a) / STEP)) + 1) for a, b in itertools.pairwise(line)]
    places = np.concatenate(parts) if parts else np.zeros((0, 2))
    return np.concatenate([places - 1.5, places + 1.5], 1)


def _around(point: F64, size: F64) -> F64:
    """Boxes (n, 4) for a name, nearest first: right, left, above, below, between, then on growing rings."""
    far = GAP * np.arange(1, RINGS + 1)[:, None, None] + size / 2
    middle = (point + np.stack([np.cos(ANGLES), np.sin(ANGLES)], -1) * far).reshape(-1, 2)
    return np.concatenate([middle - size / 2, middle + size / 2], 1)
