"""How far visibility is from the truth, in numbers. All on foreground pixels: background is 1 by definition.

Arrays are (h, w) with row 0 on top; visibility in 0..1, 1 = open; depth is the distance along the view axis, 0 =
background; masks are bool. The error is visibility minus truth. Where there is no pixel to measure the result is nan.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError
from ..io.srgb import multiply
from .images import image_flip as flip_of
from .images import image_psnr as psnr_of
from .images import image_rmse as rmse_of
from .images import image_ssim as ssim_of

F64 = NDArray[np.float64]
Mask = NDArray[np.bool_]

EDGE_JUMP = 0.01
"""A depth edge: depth departs by this share from what a plane through the neighbours would have."""

EDGE_BAND = 4
"""Half width of the band about depth edges, pixels."""

BORDER_BAND = 32
"""Width of the band along the image's border, pixels. There a screen-space method lacks what lies outside."""

FLAT_WINDOW = 5
"""Side of the window in which noise is measured, pixels: above the 4x4 tiles of common rotation textures."""

WHITE = 230
"""sRGB value of the plain picture that is dimmed when no colours are given."""


def measure(visibility: ArrayLike, truth: ArrayLike, depth: ArrayLike, *, color: ArrayLike | None = None) -> dict[str, float]:
    """Every metric of a visibility image (h, w) against its truth, with the depth (h, w) of what is seen.

    color: (h, w, 3) uint8 sRGB that is dimmed for FLIP; a light grey without it. Keys: rmse, bias, p95, p99, max, psnr,
    ssim, flip, noise, rmse_edges, rmse_interior, rmse_border. Raises FormatError for shapes that do not fit,
    SettingsError when scikit-image or flip-evaluator is missing.
    """
    a, t, z = (np.asarray(x, np.float64) for x in (visibility, truth, depth))
    if not (a.ndim == 2 and a.shape == t.shape == z.shape):
        raise FormatError(f"measure: visibility {a.shape}, truth {t.shape} and depth {z.shape} must be (h, w) and agree")
    seen = np.isfinite(z) & (z > 0)
    if not (np.isfinite(a[seen]).all() and np.isfinite(t[seen]).all()):
        raise FormatError("measure: visibility or truth is not finite on the foreground")
    a, t = np.where(seen, a, 1.0), np.where(seen, t, 1.0)
    edges = edge_band(z)
    return {
        "rmse": rmse(a, t, seen),
        "bias": bias(a, t, seen),
        "p95": percentile(a, t, seen, 95),
        "p99": percentile(a, t, seen, 99),
        "max": maximum(a, t, seen),
        "psnr": psnr(a, t, seen),
        "ssim": ssim(a, t, seen),
        "flip": flip(a, t, seen, color),
        "noise": noise(a, t, z),
        "rmse_edges": rmse(a, t, seen & edges),
        "rmse_interior": rmse(a, t, seen & ~edges),
        "rmse_border": rmse(a, t, seen & border_band(z.shape)),
    }


def rmse(visibility: F64, truth: F64, where: Mask) -> float:
    """``sqrt(mean((a - t)^2))``."""
    return _of(rmse_of, visibility, truth, where)


def bias(visibility: F64, truth: F64, where: Mask) -> float:
    """``mean(a - t)``: above 0 is too bright."""
    return _of(lambda a, t: float(np.mean(a - t)), visibility, truth, where)


def percentile(visibility: F64, truth: F64, where: Mask, share: float) -> float:
    """Return the ``|a - t|`` that ``share`` percent of the pixels stay below."""
    return _of(lambda a, t: float(np.percentile(np.abs(a - t), share)), visibility, truth, where)


def maximum(visibility: F64, truth: F64, where: Mask) -> float:
    """``max |a - t|``."""
    return _of(lambda a, t: float(np.abs(a - t).max()), visibility, truth, where)


def psnr(visibility: F64, truth: F64, where: Mask) -> float:
    """``-20 log10(rmse)`` dB, for a peak of 1; infinite for equal images."""
    return _of(psnr_of, visibility, truth, where)


def ssim(visibility: F64, truth: F64, where: Mask) -> float:
    """Structural similarity, averaged over ``where``: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment", IEEE TIP
    2004, as scikit-image computes it with a window of 7x7."""
    return ssim_of(visibility, truth, where) if where.any() else float("nan")


def flip(visibility: F64, truth: F64, where: Mask, color: ArrayLike | None = None) -> float:
    """FLIP of the pictures that they dim, averaged over ``where``, 0 (equal) to 1: Andersson et al., "FLIP: A Difference
    Evaluator for Alternating Images", HPG 2020.

    FLIP models how colours are seen, so it gets the composited sRGB picture and not the visibility itself.
    """
    if not where.any():
        return float("nan")
    base = np.full((*visibility.shape, 3), WHITE, np.uint8) if color is None else np.asarray(color)[..., :3]
    dimmed, right = (multiply(base, x) / 255 for x in (visibility, truth))
    return flip_of(dimmed, right, where)


def noise(visibility: F64, truth: F64, depth: F64) -> float:
    """Noise on flat areas: the root mean of the error's variance in windows of 5x5, ``sqrt(mean(var(a - t)))``.

    Only windows that lie wholly on the foreground and touch no band about a depth edge. Taking the error's own mean out
    of each window leaves what changes from pixel to pixel, and not the bias.
    """
    good = np.isfinite(depth) & (depth > 0) & ~edge_band(depth)
    if min(depth.shape) < FLAT_WINDOW:
        return float("nan")
    error, count = np.where(good, visibility - truth, 0.0), FLAT_WINDOW**2
    inside = _box(good.astype(np.float64)) == count
    variance = (_box(error**2) - _box(error) ** 2 / count)[inside] / (count - 1)
    return float(np.sqrt(np.maximum(variance, 0).mean())) if variance.size else float("nan")


def edge_band(depth: ArrayLike, width: int = EDGE_BAND) -> Mask:
    """(h, w): pixels within ``width`` of a depth edge, in each direction.

    A pixel is on an edge when the second difference of ``1 / z`` across it, along x or y, exceeds ``EDGE_JUMP / z``.
    Under perspective ``1 / z`` of a plane is linear in the image, so steep floors are no edges; background is 0 there,
    so silhouettes are.
    """
    z = np.asarray(depth, np.float64)
    far = ~(np.isfinite(z) & (z > 0))
    inverse = np.where(far, 0.0, 1 / np.where(far, 1.0, z))
    edge = np.zeros(z.shape, bool)
    for axis in (0, 1):
        if z.shape[axis] < 3:
            continue
        w = np.moveaxis(inverse, axis, 0)
        # By the nearest of the three: the jump as a share of the nearer surface's depth, on both its sides.
        nearest = np.maximum(np.maximum(w[:-2], w[1:-1]), w[2:])
        np.moveaxis(edge, axis, 0)[1:-1] |= np.abs(w[:-2] - 2 * w[1:-1] + w[2:]) > EDGE_JUMP * nearest
    return dilated(edge, width)


def border_band(shape: tuple[int, ...], width: int = BORDER_BAND) -> Mask:
    """(h, w): pixels within ``width`` of the image's border; all of a small image."""
    band = np.ones(shape, bool)
    band[width:-width, width:-width] = False
    return band


def dilated(mask: Mask, width: int) -> Mask:
    """Every pixel within ``width`` of a set one, along x and along y (a square)."""
    for axis in (0, 1):
        grown = mask.copy()
        for step in range(1, min(width, mask.shape[axis] - 1) + 1):
            a, b, out = (np.moveaxis(m, axis, 0) for m in (mask, mask, grown))
            out[step:] |= a[:-step]
            out[:-step] |= b[step:]
        mask = grown
    return mask


def _of(metric: Callable[[Any, Any], float], visibility: F64, truth: F64, where: Mask) -> float:
    return metric(visibility[where], truth[where]) if where.any() else float("nan")


def _box(image: F64) -> F64:
    """Return sums over every whole window of ``FLAT_WINDOW`` x ``FLAT_WINDOW`` pixels."""
    for axis in (0, 1):
        rows = np.moveaxis(image, axis, 0)
        count = len(rows) - FLAT_WINDOW + 1
        image = np.moveaxis(sum(rows[k : k + count] for k in range(FLAT_WINDOW)), 0, axis)  # type: ignore[arg-type]
    return image
