"""Comparing two pictures: numbers, and a picture of where they differ. For image tests, here and in your own suites."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError, near_miss
from ..io import images

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Difference:
    """How far two pictures are apart. Values are in units of 1/255 for integers and plain for floats."""

    max_abs: float
    mean_abs: float
    share_above_1: float
    """Share of pixels with any channel off by more than 1 (1/255 for floats in 0..1)."""
    metrics: Mapping[str, float]

    def describe(self) -> str:
        parts = [
            f"max {self.max_abs:.4g}",
            f"mean {self.mean_abs:.4g}",
            f"{100 * self.share_above_1:.3g} % of pixels off by more than 1/255",
        ]
        return ", ".join(parts + [f"{name} {value:.5g}" for name, value in self.metrics.items()])


def compare(actual: Any, expected: Any, metrics: Sequence[str] = ()) -> Difference:
    """Compare two pictures: paths or arrays (h, w) or (h, w, c) of the same shape and kind.

    Differences of uint8 are in 1/255, of uint16 in 1/65535 x 255, of floats in their own unit. ``metrics``: any of rmse,
    psnr, ssim (scikit-image), flip (flip-evaluator). Raises FormatError when they cannot be compared.
    """
    a, b = (_array(x) for x in (actual, expected))
    if a.shape != b.shape:
        raise FormatError(f"cannot compare pictures of shape {a.shape} and {b.shape}")
    if (a.dtype.kind == "f") != (b.dtype.kind == "f"):
        raise FormatError(f"cannot compare {a.dtype} with {b.dtype}; convert one of them")
    unit = {"uint8": 1.0, "uint16": 255 / 65535}.get(a.dtype.name, 1.0)
    delta = np.abs(a.astype(np.float64) * unit - b.astype(np.float64) * ({"uint16": 255 / 65535}.get(b.dtype.name, 1.0)))
    delta = np.where(np.isnan(delta), np.inf, delta)
    worst = delta if delta.ndim == 2 else delta.max(-1)
    step = 1 / 255 if a.dtype.kind == "f" else 1.0
    return Difference(
        float(delta.max()),
        float(delta.mean()),
        float((worst > step * (1 + 1e-6)).mean()),
        {name: metric(name)(_unit(a), _unit(b)) for name in metrics},
    )


def metric(name: str) -> Callable[[Array, Array], float]:
    """Return a metric by name, of two pictures in 0..1. Raises SettingsError for an unknown name."""
    known: dict[str, Callable[[Array, Array], float]] = {
        "rmse": image_rmse,
        "psnr": image_psnr,
        "ssim": image_ssim,
        "flip": image_flip,
    }
    if name not in known:
        raise SettingsError(f"unknown metric '{name}'; there are {', '.join(known)}.{near_miss(name, known)}")
    return known[name]


def image_rmse(a: Array, b: Array) -> float:
    """Root of the mean squared difference."""
    return float(np.sqrt(np.mean((a - b) ** 2)))


def image_psnr(a: Array, b: Array) -> float:
    """``-20 log10(rmse)`` in dB, for values in 0..1; infinite for equal pictures."""
    error = image_rmse(a, b)
    return float("inf") if error == 0 else float(-20 * np.log10(error))


def image_ssim(a: Array, b: Array, where: Array | None = None) -> float:
    """Structural similarity (Wang et al. 2004) as scikit-image computes it, data range 1.

    Its mean over the pixels ``where`` (h, w) bool, else over all whose window lies inside the picture.
    """
    try:
        import skimage.metrics
    except ImportError:
        raise SettingsError("ssim needs the package scikit-image: pip install 'ssao_gl[metrics]'") from None
    side = min(a.shape[:2])
    if side < 3:
        raise FormatError(f"ssim needs at least 3x3 pixels, got {a.shape[1]}x{a.shape[0]}")
    window = min(7, side - (side + 1) % 2)
    similarity: Callable[..., tuple[float, Array]] = skimage.metrics.structural_similarity
    mean, found = similarity(a, b, data_range=1.0, win_size=window, channel_axis=-1 if a.ndim == 3 else None, full=True)
    return float(mean if where is None else _mean(found, where))


def image_flip(a: Array, b: Array, where: Array | None = None) -> float:
    """Mean of NVIDIA's FLIP error (Andersson et al. 2020) at its default viewing distance, for sRGB pictures.

    Over the pixels ``where`` (h, w) bool, else over all.
    """
    try:
        import flip_evaluator
    except ImportError:
        raise SettingsError("flip needs the package flip-evaluator: pip install 'ssao_gl[metrics]'") from None
    pair = [np.ascontiguousarray(_rgb(x), np.float32) for x in (b, a)]
    found, mean, _ = flip_evaluator.evaluate(pair[0], pair[1], "LDR", applyMagma=False)
    return float(mean if where is None else _mean(np.asarray(found), where))


def _mean(values: Array, where: Array) -> float:
    """Mean over some pixels of (h, w) or (h, w, c); nan when there are none."""
    return float(values[where].mean()) if where.any() else float("nan")


def difference_picture(actual: Any, expected: Any, gain: float = 16.0) -> NDArray[np.uint8]:
    """``actual | expected | difference`` side by side (h, 3 w, 3) uint8; the difference is brightened by ``gain``."""
    a, b = (_rgb(_unit(_array(x))) for x in (actual, expected))
    return images.to_bytes(np.concatenate([a, b, np.abs(a - b) * gain], 1))


def _array(source: Any) -> Array:
    return images.load_image(source) if isinstance(source, str | Path) else np.asarray(source)


def _unit(a: Array) -> Array:
    top = {"uint8": 255.0, "uint16": 65535.0}.get(a.dtype.name, 1.0)
    return a.astype(np.float64) / top


def _rgb(a: Array) -> Array:
    return np.repeat(a[..., None], 3, -1) if a.ndim == 2 else a[..., :3] if a.shape[2] >= 3 else np.repeat(a[..., :1], 3, -1)
