"""Which balls may be in an image, which of them to draw first, and what hides the others. No OpenGL."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .projection import Matrix, ViewConstants

LEVELS = 6
"""Of a pyramid of depths, above its pixels: what is larger than two cells of the last is not looked for in it."""
TILE = 32
"""Side in pixels of the squares in which the nearest are drawn first."""


def in_view(balls: NDArray[np.float64], view: ViewConstants, projection: Matrix) -> NDArray[np.bool_]:
    """Which balls (k, 4) in view space reach into the frustum of ``projection`` between the clip planes of ``view``."""
    at, reach = balls[:, :3], balls[:, 3]
    inside = (-at[:, 2] + reach >= view.near) & (-at[:, 2] - reach <= view.far)
    for axis, side in itertools.product((0, 1), (1, -1)):
        plane = projection[3] + side * projection[axis]
        inside &= at @ plane[:3] + plane[3] >= -reach * np.linalg.norm(plane[:3])
    return np.asarray(inside)


def nearest_first(balls: NDArray[np.float64], projection: Matrix, size: tuple[int, int]) -> Iterator[NDArray[np.intp]]:
    """Yield the numbers of balls (k, 4) in view space in waves: of each square of the image the nearest, then as many again, ..."""
    with np.errstate(divide="ignore", invalid="ignore"):
        clip = balls[:, :3] @ projection[:, :3].T + projection[:, 3]
        at = np.nan_to_num(0.5 + 0.5 * clip[:, :2] / clip[:, 3:])
    square = (np.clip(at, 0, 1) * np.asarray(size) / TILE).astype(np.intp)
    number = square[:, 1] * (size[0] // TILE + 1) + square[:, 0]
    order = np.lexsort([-balls[:, 2] - balls[:, 3], number])
    _, first, count = np.unique(number[order], return_index=True, return_counts=True)
    rank = np.arange(len(order)) - np.repeat(first, count)
    start, end = 0, 1
    while start < count.max(initial=0):
        yield order[(rank >= start) & (rank < end)]
        start, end = end, 2 * end


def farthest_depths(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the farthest depth of each pixel (h, w), endless where it is 0, and of 2 x 2, 4 x 4, ... ``2**LEVELS`` squared.

    (Greene, Kass, Miller, "Hierarchical Z-Buffer Visibility", 1993.) All levels lie in one array: the pixels, made up to whole
    cells of the last level, at column 0; right of them the other levels, one above the other.
    """
    side = 1 << LEVELS
    height, width = (-(-length // side) * side for length in depth.shape)
    levels = np.zeros((height, width + width // 2), np.float32)
    levels[: depth.shape[0], : depth.shape[1]] = np.where(depth > 0, depth, np.float32(np.inf))
    last, row = levels[:, :width], 0
    for _ in range(LEVELS):
        rows = np.maximum(last[::2], last[1::2])
        last = np.maximum(rows[:, ::2], rows[:, 1::2])
        levels[row : row + last.shape[0], width : width + last.shape[1]] = last
        row += last.shape[0]
    return levels
