"""Blotches: what of an error changes slowly over flat ground, as the eye sees it there.

The error is filtered to a band of wavelengths by the difference of two Gaussians, normalised over the flat zone (Knutsson,
Westin, "Normalized and Differential Convolution", CVPR 1993), so that nothing from beyond its rim comes in. A Gaussian of
standard deviation s passes ``exp(-2 (pi s / wavelength)^2)`` of a sine's amplitude. Here each passes one half at an end of the
:data:`BAND`, hence of a sine ``(1/2)^((8 / wavelength)^2) - (1/2)^((64 / wavelength)^2)`` is left: .5 at 8 and .49 at 64 pixels,
.91 between them, .06 at 4 and .04 at 256.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
Mask = NDArray[np.bool_]

BAND = (8.0, 64.0)
"""Wavelengths between which an error is a blotch, pixels."""

SIGMA = tuple(wavelength * math.sqrt(math.log(2) / 2) / math.pi for wavelength in BAND)
"""Of the two Gaussians, pixels."""


def blotches_in(error: F64, flat: Mask) -> F64:
    """Return the part (n,) of an error (h, w) that lies in the band, at the pixels of the ``flat`` zone (h, w)."""
    from scipy.ndimage import gaussian_filter

    weight, value = flat.astype(np.float64), np.where(flat, error, 0.0)
    fine, coarse = (
        gaussian_filter(value, sigma, mode="constant")[flat] / gaussian_filter(weight, sigma, mode="constant")[flat]
        for sigma in SIGMA
    )
    return np.asarray(fine - coarse)


def noise_gain() -> float:
    """Return the share of the variance of independent noise that the band holds, in the open plane.

    The sum of the squared weights: the integral of a product of Gaussians of variances a and b in the plane is
    ``1 / (2 pi (a + b))``.
    """
    a, b = (sigma**2 for sigma in SIGMA)
    return (1 / (2 * a) - 2 / (a + b) + 1 / (2 * b)) / (2 * math.pi)
