"""Depth of a sensor, smoothed by planes that its noise allows: surfaces become flat, edges and corners stay.

In inverse depth a plane is linear in the image, and an error that grows with the distance squared is the same everywhere
(Khoshelham and Oude Elberink, Sensors 2012). So each pixel takes the mean of the planes fitted to windows that hold it
and that differ from their texels by no more than the noise; the largest such windows win. Cost: some 100 passes over the
image in numpy, about half a second for 640x480.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from .camera import Camera

RADII = (24, 12, 6, 3)
"""Of the windows, pixels; the largest that fits is taken."""
ACCEPTED = 1.6
"""A plane's largest root mean square residual, in standard deviations."""

PROBE = 6
"""Radius of the windows that tell how noisy an image is."""
MOST_SHOWN = 1.25
"""Noise that is taken for possible, of what they show."""
EXACT = 1e-5
"""Noise below which there is nothing to smooth, of the inverse depth; 32-bit floats and sums leave a tenth of it."""

Array = NDArray[np.float64]


def denoise_depth(z: Array, camera: Camera, noise: float) -> Array:
    """Return linear depth (h, w) without noise of standard deviation ``noise * z**2``; 0 stays 0.

    Raises SettingsError for cameras whose rays do not meet in the eye.
    """
    if not camera.view((z.shape[1], z.shape[0])).pinhole:
        raise SettingsError("depth noise: is modelled for perspective cameras only")
    seen = z > 0
    inverse = np.where(seen, 1 / np.where(seen, z, 1), 0)
    noise = min(noise, _shown(inverse, seen.astype(np.float64)))
    if not seen.any() or noise < EXACT * np.median(inverse[seen]):
        return z
    result, open_ = inverse.copy(), seen.copy()
    for radius in RADII:
        if 2 * radius + 1 > max(z.shape) or not open_.any():
            continue
        value, weight = _fitted(inverse, seen.astype(np.float64), radius, noise)
        taken = open_ & (weight > 0)
        result[taken] = value[taken] / weight[taken]
        open_ &= ~taken
    return np.where(seen & (result > 0), 1 / np.where(result > 0, result, 1), z * seen)


def _shown(inverse: Array, seen: Array) -> float:
    """Return the largest standard deviation that most windows of the image leave possible; inf when it is too small to tell.

    What is exact is not to be smoothed, whatever its sensor might have done: that would cost its corners.
    """
    if min(inverse.shape) <= 2 * PROBE:
        return np.inf
    count, _, _, _, residual = _planes(inverse, seen, PROBE)
    whole = count > 0.9 * (2 * PROBE + 1) ** 2
    return float(MOST_SHOWN * np.sqrt(np.quantile(residual[whole], 0.75))) if whole.any() else np.inf


def _fitted(inverse: Array, seen: Array, radius: int, noise: float) -> tuple[Array, Array]:
    """Return the sum of the accepted planes at each pixel, and of their weights."""
    count, level, a, b, residual = _planes(inverse, seen, radius)
    full = (2 * radius + 1) ** 2
    good = (count > 0.3 * full) & (residual <= (ACCEPTED * noise) ** 2)
    weights = good * np.exp(-2 * np.maximum(residual / noise**2 - 0.5, 0))
    total, weight = np.zeros_like(inverse), np.zeros_like(inverse)
    for dy in (-radius, -radius // 2, 0, radius // 2, radius):
        for dx in (-radius, -radius // 2, 0, radius // 2, radius):
            w, c, gx, gy = (_shifted(x, dy, dx) for x in (weights, level, a, b))
            total += w * (c - gx * dx - gy * dy)
            weight += w
    return total, weight


def _planes(inverse: Array, seen: Array, radius: int) -> tuple[Array, Array, Array, Array, Array]:
    """Fit ``level + a x + b y`` to the window about each pixel; return the count, these, and the mean square residual."""
    y, x = np.mgrid[: inverse.shape[0], : inverse.shape[1]].astype(np.float64)
    cx, cy = x.copy(), y.copy()
    x, y = x - x.mean(), y - y.mean()
    cx, cy = cx - cx.mean(), cy - cy.mean()
    w = inverse * seen
    n, sx, sy, sxx, sxy, syy, sw, sxw, syw, sww = (
        _box(q, radius) for q in (seen, seen * x, seen * y, seen * x * x, seen * x * y, seen * y * y, w, w * x, w * y, w * w)
    )
    n = np.maximum(n, 1e-9)
    mx, my, mw = sx / n, sy / n, sw / n
    vxx, vxy, vyy = sxx / n - mx * mx, sxy / n - mx * my, syy / n - my * my
    vxw, vyw, vww = sxw / n - mx * mw, syw / n - my * mw, sww / n - mw * mw
    det = vxx * vyy - vxy * vxy
    safe = det > 1e-3 * radius**4 / 9
    det = np.where(safe, det, 1)
    a = np.where(safe, (vxw * vyy - vyw * vxy) / det, 0)
    b = np.where(safe, (vyw * vxx - vxw * vxy) / det, 0)
    residual = np.maximum(vww - a * vxw - b * vyw, 0)
    return np.where(safe, n, 0), mw + a * (cx - mx) + b * (cy - my), a, b, residual


def _box(values: Array, radius: int) -> Array:
    """Return sums over windows of side ``2 radius + 1``, cut at the borders."""
    for axis in (0, 1):
        side = values.shape[axis]
        sums = np.concatenate([np.zeros_like(values.take([0], axis)), values.cumsum(axis)], axis)
        index = np.arange(side)
        values = sums.take(np.minimum(index + radius + 1, side), axis) - sums.take(np.maximum(index - radius, 0), axis)
    return values


def _shifted(values: Array, dy: int, dx: int) -> Array:
    """Return ``values[y + dy, x + dx]``, 0 outside."""
    h, w = values.shape
    out = np.zeros_like(values)
    if abs(dy) < h and abs(dx) < w:
        to = (slice(max(-dy, 0), h - max(dy, 0)), slice(max(-dx, 0), w - max(dx, 0)))
        out[to] = values[max(dy, 0) : h + min(dy, 0), max(dx, 0) : w + min(dx, 0)]
    return out
