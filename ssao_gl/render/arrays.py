"""What callers hand in, checked and in the types that are uploaded."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError
from ..pipeline.build import EYE_DEPTH, WINDOW_DEPTH
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.model import RADIUS_SHARE
from ..scene.projection import Size

MAX_SIDE = 1 << 16


def check_size(size: Size) -> None:
    """Raise SettingsError unless ``size`` is (width, height) with sides from 1 to 65536."""
    if len(size) != 2 or not all(1 <= side <= MAX_SIDE and side == int(side) for side in size):
        raise SettingsError(f"size {'x'.join(map(str, size))}: must be WIDTHxHEIGHT with sides from 1 to {MAX_SIDE}")


def settled_depth(depth: NDArray[Any] | DepthImage, kind: str, camera: Camera) -> tuple[NDArray[Any], str]:
    """Return depth that shaders read, and its kind: eye, or window, which they linearize. Raises FormatError, SettingsError."""
    if kind == WINDOW_DEPTH and not isinstance(depth, DepthImage):
        return depth, kind
    image = depth if isinstance(depth, DepthImage) else DepthImage(depth, kind, empty="warn")
    return image.linear(camera), EYE_DEPTH


def check_arrays(
    depth: NDArray[Any], color: NDArray[Any] | None, normals: NDArray[Any] | None
) -> tuple[NDArray[np.float32], NDArray[np.uint8] | None, NDArray[np.float32] | None]:
    """Return the caller's arrays in the types that are uploaded. Raises FormatError naming what does not fit."""
    depth = np.asarray(depth)
    if depth.ndim != 2 or depth.dtype.kind not in "fiu" or not depth.size:
        raise FormatError(f"depth is {depth.dtype} of shape {depth.shape}; expected numbers of shape (h, w)")
    with np.errstate(over="ignore"):
        depth = depth.astype(np.float32)
    if color is not None:
        color = np.asarray(color)
        if color.dtype != np.uint8 or color.ndim != 3 or color.shape[2] not in (3, 4) or color.shape[:2] != depth.shape:
            raise FormatError(
                f"color is {color.dtype} of shape {color.shape}; expected uint8 sRGB of shape {(*depth.shape, 3)} or {(*depth.shape, 4)}"
            )
    if normals is not None:
        normals = np.asarray(normals)
        if normals.dtype.kind != "f" or normals.shape != (*depth.shape, 3):
            raise FormatError(
                f"normals are {normals.dtype} of shape {normals.shape}; expected floats of shape {(*depth.shape, 3)}, view space"
            )
        with np.errstate(over="ignore"):
            normals = normals.astype(np.float32)
    return depth, color, normals


def radius_of(depth: NDArray[np.float32], camera: Camera, kind: str) -> float:
    """Return an automatic radius for a depth image: a share of the extent of the middle 96 % of its points."""
    if kind != "eye":
        raise SettingsError("radius: window depth needs a radius in scene units")
    usable = (depth > 2.0**-63) & (depth < 2.0**63)  # what linearize.frag takes for distances
    points = camera.view(depth.shape[::-1]).points(np.where(usable, depth, 0))[usable]
    if not len(points):
        return 1.0
    low, high = np.percentile(points, (2, 98), axis=0)
    return RADIUS_SHARE * float(np.linalg.norm(high - low)) or 1.0
