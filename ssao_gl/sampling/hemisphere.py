"""Cosine-weighted directions over hemispheres: a scrambled Sobol set, shifted anew for every pixel."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]


@lru_cache(maxsize=64)
def sobol_points(count: int, seed: int, batch: int) -> F64:
    """``count`` points (count, 2) in [0, 1)^2 of a Sobol sequence with its own scramble for each batch.

    scipy's scramble: a random lower triangular matrix and a digital shift (Matousek, "On the L2-discrepancy for anchored
    boxes", J. Complexity 1998), which keeps the nets that Owen's keeps and has the same variance. Raises SettingsError
    without scipy.
    """
    try:
        from scipy.stats import qmc
    except ImportError:
        raise SettingsError("tracing rays needs the package scipy: pip install 'ssao_gl[truth]'") from None
    engine = qmc.Sobol(2, scramble=True, seed=np.random.default_rng([seed, batch]))
    drawn: F64 = engine.random_base2(count.bit_length() - 1)
    drawn.setflags(write=False)
    return drawn


def hemisphere_directions(normals: F32, samples: F64, random: np.random.Generator) -> Iterator[F32]:
    """One direction for every normal (n, 3), unit length (n, 3) float32, for each of ``samples`` (m, 2).

    With ``(u, v)`` a sample, the direction is ``sqrt(1 - u)`` along the normal and ``sqrt(u)`` away from it at angle
    ``2 pi v``: density cos(theta) / pi (Malley). Each pixel flips the bits of ``u`` by its own mask and turns ``v`` by
    its own angle; both keep the strata, and make the pixels' errors independent. The array given is used again.
    """
    count = len(normals)
    # The upper 23 bits of a sample below the exponent of 1.0: flipping them there gives a float in [1, 2) without a cast.
    mask = random.integers(0, 1 << 23, count, np.uint32) | np.uint32(0x3F800000)
    heights = (samples[:, 0] * 2.0**23).astype(np.uint32)
    tangent, bitangent = _turned_frames(normals, random.random(count, np.float32) * np.float32(2 * np.pi))
    up = np.ascontiguousarray(normals.T)
    angles = 2 * np.pi * samples[:, 1]
    out, other = np.empty((3, count), np.float32), np.empty((3, count), np.float32)
    bits, u, side = np.empty(count, np.uint32), np.empty(count, np.float32), np.empty(count, np.float32)
    for height, c, s in zip(heights, np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32), strict=True):
        np.bitwise_xor(mask, height, out=bits)
        np.subtract(bits.view(np.float32), np.float32(1 - 2.0**-24), out=u)  # the middles of 2^23 steps: never 0 or 1
        np.sqrt(u, out=side)
        np.subtract(np.float32(1), u, out=u)
        np.sqrt(u, out=u)
        np.multiply(tangent, c, out=out)
        np.multiply(bitangent, s, out=other)
        out += other
        out *= side
        np.multiply(up, u, out=other)
        out += other
        yield out.T


def frames(normals: F32) -> tuple[F32, F32]:
    """Two unit vectors (3, n) at right angles to each normal (3, n) and to each other.

    The frame without a seam of Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
    """
    x, y, z = normals
    sign = np.where(z < 0, np.float32(-1), np.float32(1))
    a = -1 / (sign + z)
    b = x * y * a
    first: F32 = np.stack([1 + sign * x * x * a, sign * b, -sign * x])
    second: F32 = np.stack([b, sign + y * y * a, -y])
    return first, second


def _turned_frames(normals: F32, turn: F32) -> tuple[F32, F32]:
    """Return :func:`frames` of normals (n, 3), turned about them by ``turn`` (n,)."""
    first, second = frames(normals.T)
    c: F32 = np.cos(turn)
    s: F32 = np.sin(turn)
    return c * first + s * second, c * second - s * first
