"""How far visibility is from the truth, in numbers. All on foreground pixels: background is 1 by definition.

Arrays are (h, w) with row 0 on top; visibility in 0..1, 1 = open; masks are bool. The error is visibility minus truth. Where there is no pixel to measure the result is nan.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError
from ..io.srgb import multiply
from .blotches import blotches_in, noise_gain
from .images import image_flip as flip_of
from .images import image_psnr as psnr_of
from .images import image_rmse as rmse_of
from .images import image_ssim as ssim_of
from .zones import ZONES, Zones

F64 = NDArray[np.float64]
Mask = NDArray[np.bool_]

BORDER_BAND = 32
"""Width of the band along the image's border, pixels. There a screen-space method lacks what lies outside."""

FLAT_WINDOW = 5
"""Side of the window in which noise is measured, pixels: above the 4x4 tiles of common rotation textures."""

WHITE = 230
"""sRGB value of the plain picture that is dimmed when no colours are given."""


def measure(
    visibility: ArrayLike, truth: ArrayLike, zones: Zones, *, stderr: ArrayLike | None = None, color: ArrayLike | None = None
) -> dict[str, float]:
    """Every metric of a visibility image (h, w) against its truth, in all of the zones of the view and in each.

    stderr: (h, w), standard errors of the truth, by which ``_net`` is less: ``sqrt(max(rmse^2 - mean(stderr^2), 0))``; nan
    without it. color: (h, w, 3) uint8 sRGB that is dimmed for FLIP; a light grey without it. Keys: rmse, rmse_net, bias, p95,
    p99, max, psnr, ssim, flip, noise, rmse_border, blotches, blotches_net, and of each zone rmse, rmse_net, bias and share: of
    the squared error without the truth's noise, 0..1. Raises FormatError for shapes that do not fit, SettingsError when
    scikit-image or flip-evaluator is missing.
    """
    a, t, seen = np.asarray(visibility, np.float64), np.asarray(truth, np.float64), zones.seen
    s = np.full(seen.shape, np.nan) if stderr is None else np.asarray(stderr, np.float64)
    if not (a.ndim == 2 and a.shape == t.shape == seen.shape == s.shape):
        raise FormatError(f"measure: visibility {a.shape}, truth {t.shape} and zones {seen.shape} must be (h, w) and agree")
    if not (np.isfinite(a[seen]).all() and np.isfinite(t[seen]).all()):
        raise FormatError("measure: visibility or truth is not finite on the foreground")
    a, t = np.where(seen, a, 1.0), np.where(seen, t, 1.0)
    return {
        "rmse": rmse(a, t, seen),
        "rmse_net": net(rmse(a, t, seen), s, seen),
        "bias": bias(a, t, seen),
        "p95": percentile(a, t, seen, 95),
        "p99": percentile(a, t, seen, 99),
        "max": maximum(a, t, seen),
        "psnr": psnr(a, t, seen),
        "ssim": ssim(a, t, seen),
        "flip": flip(a, t, seen, color),
        "noise": noise(a, t, zones.flat),
        "rmse_border": rmse(a, t, seen & border_band(seen.shape)),
        "blotches": blotches(a, t, zones.flat),
        "blotches_net": net(blotches(a, t, zones.flat), s, zones.flat, noise_gain()),
        **_by_zone(a, t, s, zones),
    }


def _by_zone(a: F64, t: F64, stderr: F64, zones: Zones) -> dict[str, float]:
    """``rmse_edge``, ``rmse_edge_net``, ``bias_edge``, ``share_edge``, and so on: metrics of each zone."""
    found: dict[str, float] = {}
    squares = {}
    for name in ZONES:
        where = getattr(zones, name)
        here = rmse(a, t, where)
        clean = net(here, stderr, where)
        squares[name] = where.sum() * clean**2 if where.any() else 0.0
        found |= {f"rmse_{name}": here, f"rmse_{name}_net": clean, f"bias_{name}": bias(a, t, where)}
    total = sum(squares.values())
    return found | {f"share_{name}": float(one / total) if total else float("nan") for name, one in squares.items()}


def net(error: float, stderr: F64, where: Mask, gain: float = 1.0) -> float:
    """Return a root mean square error without the noise of the truth, ``sqrt(max(error^2 - gain mean(stderr^2), 0))``.

    The truth's noise is independent of the method's error, so their squares add up. stderr: (h, w), of each pixel of the
    truth. gain: the share of the noise's variance that ``error`` holds.
    """
    return float(np.sqrt(np.maximum(error**2 - gain * np.mean(stderr[where] ** 2), 0))) if where.any() else float("nan")


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


def noise(visibility: F64, truth: F64, flat: Mask) -> float:
    """Noise on flat areas: the root mean of the error's variance in windows of 5x5, ``sqrt(mean(var(a - t)))``.

    Only windows that lie wholly in the ``flat`` zone. Taking the error's own mean out of each window leaves what changes from
    pixel to pixel, and not the bias.
    """
    if min(flat.shape) < FLAT_WINDOW:
        return float("nan")
    error, count = np.where(flat, visibility - truth, 0.0), FLAT_WINDOW**2
    inside = _box(flat.astype(np.float64)) == count
    variance = (_box(error**2) - _box(error) ** 2 / count)[inside] / (count - 1)
    return float(np.sqrt(np.maximum(variance, 0).mean())) if variance.size else float("nan")


def blotches(visibility: F64, truth: F64, flat: Mask) -> float:
    """Blotches: root mean square, over the ``flat`` zone, of the error's part with wavelengths of 8 to 64 pixels.

    See :mod:`.blotches` for the band.
    """
    return float(np.sqrt(np.mean(blotches_in(visibility - truth, flat) ** 2))) if flat.any() else float("nan")


def border_band(shape: tuple[int, ...], width: int = BORDER_BAND) -> Mask:
    """(h, w): pixels within ``width`` of the image's border; all of a small image."""
    band = np.ones(shape, bool)
    band[width:-width, width:-width] = False
    return band


def _of(metric: Callable[[Any, Any], float], visibility: F64, truth: F64, where: Mask) -> float:
    return metric(visibility[where], truth[where]) if where.any() else float("nan")


def _box(image: F64) -> F64:
    """Return sums over every whole window of ``FLAT_WINDOW`` x ``FLAT_WINDOW`` pixels."""
    for axis in (0, 1):
        rows = np.moveaxis(image, axis, 0)
        count = len(rows) - FLAT_WINDOW + 1
        image = np.moveaxis(sum(rows[k : k + count] for k in range(FLAT_WINDOW)), 0, axis)  # type: ignore[arg-type]
    return image
