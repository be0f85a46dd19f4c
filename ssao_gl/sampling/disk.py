"""The sample kernel and the rotation texture: where a method looks, seeded and the same on every machine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..settings import setting, validate

GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """Points of the unit disk, of equal weight."""

    count: int = setting(16, "points", low=1, high=256)
    distribution: str = setting("spiral", "how the points lie in the disk", choices=("spiral", "hammersley", "uniform"))
    seed: int = setting(0, "of the uniform distribution", low=0, high=2**31 - 1)

    def __post_init__(self) -> None:
        validate(self)

    def points(self) -> NDArray[np.float32]:
        """(count, 2) float32 offsets with length < 1, uniform in area.

        spiral: Vogel's sunflower, ``r = sqrt((i + 1/2) / n)`` at steps of the golden angle. hammersley: the set
        ``(i + 1/2) / n``, radical inverse of i in base 2. uniform: independent random points.
        """
        i = np.arange(self.count)
        area = (i + 0.5) / self.count
        if self.distribution == "spiral":
            angle = i * GOLDEN_ANGLE
        elif self.distribution == "hammersley":
            angle = 2 * np.pi * np.array([radical_inverse(int(k)) for k in i])
        else:
            area, angle = np.random.default_rng(self.seed).random((2, self.count)) * [[1], [2 * np.pi]]
        radius = np.sqrt(area)
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1).astype(np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rotation:
    """A small tile of unit vectors, repeated over the image, that turns the kernel from pixel to pixel."""

    tile: int = setting(4, "width and height of the tile; a blur as wide removes its pattern", unit="pixels", low=1, high=64)
    distribution: str = setting(
        "stratified", "evenly spaced angles in a scattered order, or random ones", choices=("stratified", "random")
    )
    seed: int = setting(0, "of the order, or of the angles", low=0, high=2**31 - 1)

    def __post_init__(self) -> None:
        validate(self)

    def vectors(self) -> NDArray[np.float32]:
        """(tile, tile, 2) float32 unit vectors. Reflecting at them turns a kernel through the full circle, evenly."""
        count = self.tile * self.tile
        rng = np.random.default_rng(self.seed)
        if self.distribution == "stratified":
            order = bayer(self.tile) if self.tile & (self.tile - 1) == 0 else rng.permutation(count)
            turns = (order + 0.5) / count
        else:
            turns = rng.random(count)
        angle = np.pi * turns.reshape(self.tile, self.tile)  # a reflection turns by twice the angle
        return np.stack([np.cos(angle), np.sin(angle)], -1).astype(np.float32)


def radical_inverse(index: int) -> float:
    """Van der Corput's sequence in base 2: the bits of ``index`` mirrored about the binary point."""
    value, base = 0.0, 0.5
    while index:
        value += base * (index & 1)
        index >>= 1
        base /= 2
    return value


def bayer(size: int) -> NDArray[np.int64]:
    """Return the ordered-dither matrix (size a power of two), flattened: neighbours differ as much as they can."""
    matrix = np.zeros((1, 1), np.int64)
    while len(matrix) < size:
        matrix = np.block([[4 * matrix, 4 * matrix + 2], [4 * matrix + 3, 4 * matrix + 1]])
    return matrix.ravel()


def _show() -> None:
    """Print the default kernel and rotation tile as numbers and as a picture in text."""
    import sys

    points = Kernel().points()
    canvas = [[" "] * 41 for _ in range(21)]
    for index, (x, y) in enumerate(points):
        canvas[round(10 - 10 * float(y))][round(20 + 20 * float(x))] = format(index % 16, "x")
    lines = ["".join(row) for row in canvas]
    lines += [f"{i:3d}  {x:+.4f} {y:+.4f}" for i, (x, y) in enumerate(points)]
    lines += ["rotation tile, degrees:"]
    angles = np.degrees(np.arctan2(Rotation().vectors()[..., 1], Rotation().vectors()[..., 0]))
    lines += [" ".join(f"{angle:7.2f}" for angle in row) for row in angles]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    _show()
