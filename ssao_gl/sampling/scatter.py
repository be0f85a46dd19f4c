"""Rays scattered over an image: which pixels have how many, and where in the hemisphere they go.

Both follow the Z-order of the pixels (Morton 1966): what is stratified along that curve is stratified in every aligned square of
2^k x 2^k pixels. So a quarter of a ray a pixel is one in each 2x2 block, and the rays of neighbouring pixels are points of
one low-discrepancy sequence, whose errors a filter over the neighbours cancels (Ahmed & Wonka, "Screen-Space Blue-Noise
Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", ACM TOG 2020). Everything depends on the place in
the whole picture alone: tiles of it get the same rays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

U32 = NDArray[np.uint32]
F32 = NDArray[np.float32]


SEED = 0x5EED
"""Of the digital shifts of directions, and of the places of rays."""

KEPT_RAYS = 1 << 20
"""Layers of at most so many rays are kept for the next frame, 16 MiB each; larger ones cost little beside their tracing."""


@dataclass(frozen=True, eq=False)
class RayLayer:
    """At most one ray of each pixel of a part of a picture, row 0 at the bottom.

    pixel: (n,) int32, numbers of pixels in the part, in Z-order: what is traced together lies together. direction: (3, n) float32,
    unit, cosine-weighted about the third axis.
    """

    pixel: NDArray[np.int32]
    direction: F32


def ray_layers(corner: tuple[int, int], size: tuple[int, int], whole: tuple[int, int], share: float) -> Iterator[RayLayer]:
    """Yield the rays of a part of a picture of ``whole`` (width, height) pixels: ``share`` of a ray a pixel in all.

    corner, size: of the part, in pixels from the lower left of the picture; what lies beside the picture has no rays.
    """
    full, rest = divmod(share, 1)
    wanted = [(1.0, int(full), number) for number in range(int(full))] + ([(rest, 1, 0)] if rest > 0 else [])
    for part, stride, number in wanted:
        make = _kept_layer if size[0] * size[1] * part <= KEPT_RAYS else _layer
        yield make(corner, size, whole, part, stride, number)


def _layer(
    corner: tuple[int, int], size: tuple[int, int], whole: tuple[int, int], share: float, stride: int, number: int
) -> RayLayer:
    """Return a layer; a pixel's rays in ``stride`` full ones follow each other in the sequence."""
    y, x = np.indices(size[::-1], np.int32)
    inside = (x + corner[0] >= 0) & (x + corner[0] < whole[0]) & (y + corner[1] >= 0) & (y + corner[1] < whole[1])
    order = z_order(np.maximum(x + corner[0], 0), np.maximum(y + corner[1], 0))
    pixel = np.flatnonzero(inside & has_ray(order, share)).astype(np.int32)
    pixel = pixel[np.argsort(order.ravel()[pixel], kind="stable")]
    index = np.floor(order.ravel()[pixel] * share).astype(np.uint32)
    if stride > 1:
        index = index * np.uint32(stride) + np.uint32(number)
    first, second = hashed(np.array([SEED, SEED + 1], np.uint32) + np.uint32(2 * (share < 1)))
    u, v = sobol_pairs(index, (int(first), int(second)))
    away, angle = np.sqrt(u), v * np.float32(2 * np.pi)
    return RayLayer(pixel, np.stack([away * np.cos(angle), away * np.sin(angle), np.sqrt(1 - u)]))


_kept_layer = lru_cache(maxsize=4)(_layer)


def z_order(x: NDArray[np.integer], y: NDArray[np.integer]) -> U32:
    """Return the numbers of pixels along the Z-order curve: the bits of ``x`` and ``y``, 16 each, in turns."""
    return _spread(x) | _spread(y) << np.uint32(1)


def has_ray(order: U32, share: float) -> NDArray[np.bool_]:
    """Return which of the pixels with these Z-order numbers have a ray, for a ``share`` of at most 1.

    Of each stretch of ``1 / share`` pixels along the curve one, at a place by the stretch's hash.
    """
    if share >= 1:
        return np.ones(order.shape, bool)
    slack = 1e-6  # of a ray: what rounding may move the edge of a stretch by
    stretch = np.floor(order * share + slack)
    start, end = (np.ceil((edge - slack) / share) for edge in (stretch, stretch + 1))
    chosen: NDArray[np.bool_] = start + np.floor((end - start) * hashed(stretch.astype(np.uint32)) * 2.0**-32) == order
    return chosen


def sobol_pairs(index: U32, shift: tuple[int, int]) -> F32:
    """Return the points (2, n) of the (0, 2)-sequence in base 2 with these indices, in [0, 1); ``shift``: a digital shift, 32 bits each.

    Its first two Sobol dimensions, by the bytes of the index (Kollig & Keller, "Efficient Multidimensional Sampling", CGF 2002).
    """
    points = np.empty((2, *index.shape), np.float32)
    for axis, table in enumerate(_byte_tables()):
        bits = np.full(index.shape, shift[axis], np.uint32)
        for byte in range(4):
            bits ^= table[byte][index >> np.uint32(8 * byte) & np.uint32(255)]
        points[axis] = (bits >> np.uint32(8)) * np.float32(2.0**-24)
    return points


def hashed(values: U32) -> U32:
    """Return 32 well-mixed bits for each number (``lowbias32`` of Wellons, "Prospecting for Hash Functions", 2018)."""
    x = values.copy()
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        x ^= x >> np.uint32(shift)
        x *= np.uint32(factor)
    return np.asarray(x ^ x >> np.uint32(16))


def _spread(values: NDArray[np.integer]) -> U32:
    """Return numbers of 16 bits with a 0 after each bit."""
    x = values.astype(np.uint32)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        x = (x | x << np.uint32(shift)) & np.uint32(mask)
    return x


@cache
def _byte_tables() -> tuple[U32, U32]:
    """Return what each byte of an index adds: (4, 256) for either dimension."""
    reversed_bits, pascal = [1 << 31 - k for k in range(32)], [1 << 31]
    for _ in range(31):
        pascal.append(pascal[-1] ^ pascal[-1] >> 1)
    first, second = (_xor_table(directions) for directions in (reversed_bits, pascal))
    return first, second


def _xor_table(directions: list[int]) -> U32:
    table = np.zeros((4, 256), np.uint32)
    for bit, direction in enumerate(directions):
        table[bit // 8][np.arange(256) >> bit % 8 & 1 == 1] ^= np.uint32(direction)
    return table
