"""Points of the unit ball, and planes to reflect them at: where the methods of 2007 and 2008 look. Nothing is random."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .disk import GOLDEN_ANGLE, bayer, radical_inverse


def sphere_points(count: int) -> NDArray[np.float32]:
    """(count, 3) float32 points with length < 1, spread evenly in volume.

    Directions are a spherical Fibonacci lattice; lengths are cube roots of Van der Corput's sequence, so that
    near and far points alternate.
    """
    i = np.arange(count)
    length = np.cbrt([radical_inverse(int(k)) + 0.5 / count for k in i])
    return (length[:, None] * _fibonacci(1 - (2 * i + 1) / count)).astype(np.float32)


def reflection_planes(tile: int) -> NDArray[np.float32]:
    """(tile, tile, 4) float32: unit normals over half the sphere, neighbours far apart, and 0; ``tile`` is a power of two."""
    count = tile * tile
    normals = _fibonacci((np.arange(count) + 0.5) / count)[bayer(tile)]
    return np.pad(normals, ((0, 0), (0, 1))).reshape(tile, tile, 4).astype(np.float32)


def _fibonacci(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit vectors (n, 3) at the heights z, each turned by the golden angle from the one before."""
    angle = np.arange(len(z)) * GOLDEN_ANGLE
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], 1)
