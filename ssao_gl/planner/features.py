"""What small pictures of a view tell of the errors that large ones will have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scene.projection import ViewConstants

F32 = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class ViewFeatures:
    """Numbers in 0..1 about a view, over its pixels that are not background; all 0 where there are none."""

    sampling: float
    """RMS of what half of the steps change."""
    hidden: float
    """RMS of what a second layer changes; 0 where there is none to be had."""
    rough: float
    """RMS of how far neighbours lie off a pixel's tangent plane, in radii and no more than one: what sampling can miss."""
    contrast: float
    """RMS of occlusion, times the root of ``rough``."""


def view_features(
    fine: F32, coarse: F32, deep: F32 | None, depth: F32, normals: F32, view: ViewConstants, radius: float
) -> ViewFeatures:
    """From visibilities (h, w) of many steps, of few, and of two layers; depth (h, w) and normals (h, w, 3) of the same view."""
    seen = depth > 0
    if not seen.any():
        return ViewFeatures(0.0, 0.0, 0.0, 0.0)
    rough = _rms(off_plane(depth, normals, view, radius)[seen])
    return ViewFeatures(
        sampling=_rms((fine - coarse)[seen]),
        hidden=0.0 if deep is None else _rms((fine - deep)[seen]),
        rough=rough,
        contrast=_rms(1 - fine[seen]) * rough**0.5,
    )


def off_plane(depth: F32, normals: F32, view: ViewConstants, radius: float) -> NDArray[np.float64]:
    """(h, w): how far off its tangent plane the worst of a pixel's four neighbours lies, in radii, at most 1; 0 on background."""
    points, seen = view.points(depth), depth > 0
    worst = np.zeros(depth.shape)
    for axis in (0, 1):
        first = (slice(None), slice(None, -1)) if axis else (slice(None, -1), slice(None))
        last = (slice(None), slice(1, None)) if axis else (slice(1, None), slice(None))
        step, both = points[last] - points[first], seen[first] & seen[last]
        for here in (first, last):
            off = np.abs((step * normals[here]).sum(-1)) / radius
            worst[here] = np.maximum(worst[here], np.where(both, np.minimum(off, 1), 0))
    return worst


def _rms(values: NDArray[np.floating]) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))
