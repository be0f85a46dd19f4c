"""What is known at the size of a depth image, brought to the size of its colour along the edges of both.

Joint bilateral upsampling (Kopf, Cohen, Lischinski and Uyttendaele, ACM Transactions on Graphics 26(3), 2007) over the four
nearest texels. Surfaces are not mixed: of the four only those count that lie near the distance of the likeliest one. Inverse
depth is what is interpolated, in which planes are linear. Cost: some 100 passes over the colour in numpy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .projection import Size

TONE = 0.1
"""Standard deviation of the colour weight, of 0..1."""
SAME = 0.08
"""Largest relative difference in distance within one surface."""
MOST_STRETCHED = 0.02
"""Largest relative difference between the proportions of colour and depth."""


class JointUpsampling:
    """The weights that bring images of the size of ``depth`` (h, w) to the size of ``color`` (H, W, 3 or 4) uint8."""

    def __init__(self, depth: NDArray[np.float32], color: NDArray[np.uint8]) -> None:
        """``depth``: linear, 0 = background. Raises FormatError for sizes that do not go together."""
        h, w = depth.shape
        height, width = color.shape[:2]
        check_upsampled((w, h), (width, height))
        tone = color[..., :3].astype(np.float32) / 255
        y, x = (np.arange(height) + 0.5) * h / height - 0.5, (np.arange(width) + 0.5) * w / width - 0.5
        low_y, low_x = np.floor(y).astype(int), np.floor(x).astype(int)
        self._taps = []
        weights = []
        for dy in (0, 1):
            for dx in (0, 1):
                row, column = np.clip(low_y + dy, 0, h - 1), np.clip(low_x + dx, 0, w - 1)
                near = np.outer(1 - np.abs(y - low_y - dy), 1 - np.abs(x - low_x - dx))
                middle_y = np.minimum(((row + 0.5) * height / h).astype(int), height - 1)
                middle_x = np.minimum(((column + 0.5) * width / w).astype(int), width - 1)
                apart = ((tone - tone[np.ix_(middle_y, middle_x)]) ** 2).sum(-1)
                weights.append((near + 1e-6) * np.exp(-apart / (2 * TONE**2)) + 1e-12)
                self._taps.append(np.ix_(row, column))
        z = np.stack([depth[tap] for tap in self._taps])
        inverse = np.where(z > 0, 1 / np.where(z > 0, z, 1), 0)
        weight = np.stack(weights)
        likeliest = np.take_along_axis(inverse, weight.argmax(0)[None], 0)
        weight *= np.abs(inverse - likeliest) <= SAME * likeliest
        self._weight = (weight / weight.sum(0)).astype(np.float32)
        mean = (inverse * self._weight).sum(0)
        self.depth: NDArray[np.float32] = np.where(mean > 0, 1 / np.where(mean > 0, mean, 1), 0).astype(np.float32)
        """Linear depth (H, W)."""

    def mean(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Return ``values`` (h, w) or (h, w, c) at the larger size."""
        total: NDArray[Any] = np.zeros((), np.float32)
        for tap, weight in zip(self._taps, self._weight, strict=True):
            total = total + values[tap] * (weight if values.ndim == 2 else weight[..., None])
        return total.astype(np.float32)

    def directions(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Return unit vectors (h, w, 3) at the larger size; (0, 0, 0) stays that."""
        mean = self.mean(values)
        length = np.linalg.norm(mean, axis=-1, keepdims=True)
        return np.where(length > 0, mean / np.where(length > 0, length, 1), 0).astype(np.float32)


def check_upsampled(size: Size, larger: Size) -> None:
    """Raise FormatError unless ``larger`` is an image of the same proportions, and no smaller along either side."""
    (w, h), (width, height) = size, larger
    if height < h or width < w or abs(height * w / (width * h) - 1) > MOST_STRETCHED:
        raise FormatError(
            f"color is {width}x{height}, depth {w}x{h}; expected the same size, or larger colour of the same proportions"
        )
