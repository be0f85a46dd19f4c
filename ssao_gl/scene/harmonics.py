"""Spherical harmonics up to band 2: light from all around, in nine colours.

Ramamoorthi, Hanrahan, "An Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001. Coefficients are kept
times the constants of their functions, so that radiance is the plain polynomial
``c0 + c1 y + c2 z + c3 x + c4 x y + c5 y z + c6 (3 z^2 - 1) + c7 x z + c8 (x^2 - y^2)``; y is up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError

Coefficients = tuple[float, ...]
"""27 numbers: nine times linear (r, g, b)."""


def polynomials(directions: ArrayLike) -> NDArray[np.float64]:
    """Return the nine polynomials (..., 9) of unit directions (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(directions, np.float64), -1, 0)
    return np.stack([np.ones_like(x), y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y], -1)


def constant(color: ArrayLike) -> Coefficients:
    """Return the same light (3,) from everywhere."""
    return gradient(color, color)


def gradient(above: ArrayLike, below: ArrayLike) -> Coefficients:
    """Return light that goes from ``below`` (3,) to ``above`` with the height of its direction."""
    top, bottom = np.asarray(above, np.float64), np.asarray(below, np.float64)
    out = np.zeros((9, 3))
    out[0], out[1] = (top + bottom) / 2, (top - bottom) / 2
    return tuple(out.ravel().tolist())


def projected(panorama: NDArray[np.floating]) -> Coefficients:
    """Return the coefficients of an equirectangular picture (h, w, 3) of linear light, row 0 at the top.

    Its middle lies towards -z, and columns go to the right from there, as in glTF viewers. Least squares over the sphere, so that what
    the functions can hold comes back whatever the size. Raises FormatError.
    """
    h, w = panorama.shape[:2]
    if panorama.ndim != 3 or panorama.shape[2] != 3 or min(h, w) < 4 or not np.isfinite(panorama).all() or panorama.min() < 0:
        raise FormatError("environment: must be (h, w, 3) numbers of linear light, at least 4 x 4, finite and nowhere below 0")
    theta = np.pi * (np.arange(h) + 0.5) / h
    phi = 2 * np.pi * (np.arange(w) + 0.5) / w - np.pi
    share = 2 * np.pi / w * (np.cos(np.pi * np.arange(h) / h) - np.cos(np.pi * (np.arange(h) + 1) / h))
    gram, total = np.zeros((9, 9)), np.zeros((9, 3))
    for row in range(h):  # a row at a time: nine times a large picture need not fit into memory
        sine = np.sin(theta[row])
        directions = np.stack([sine * np.sin(phi), np.full(w, np.cos(theta[row])), -sine * np.cos(phi)], -1)
        functions = polynomials(directions)
        gram += share[row] * functions.T @ functions
        total += share[row] * functions.T @ panorama[row].astype(np.float64)
    return tuple(np.linalg.solve(gram, total).ravel().tolist())
