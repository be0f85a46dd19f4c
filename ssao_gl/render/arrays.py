"""What callers hand in, checked and in the types that are uploaded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, SceneError, SettingsError
from ..pipeline.build import EYE_DEPTH, WINDOW_DEPTH
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.depth_image import LEAST, MOST, DepthImage
from ..scene.model import RADIUS_SHARE, Scene


def check_kinds(scene: object, camera: object, settings: object) -> None:
    """Raise SceneError or SettingsError for what belongs to somebody else; the check that a type checker makes before."""
    if not isinstance(scene, Scene):
        raise SceneError(f"Renderer: cannot draw a {type(scene).__name__}; expected a Scene: ssao_gl.as_scene(...) makes one")
    if not isinstance(camera, Camera | None):
        raise SettingsError(f"Renderer: cannot use a {type(camera).__name__} as camera; expected a Camera")
    if not isinstance(settings, Settings | None):
        raise SettingsError(
            f"Renderer: settings are a {type(settings).__name__}; expected Settings, like Settings(method=Bitmask())"
        )


def is_fine(bits: int, aovs: Sequence[str]) -> bool:
    """Return whether visibility is to end in half floats. Raises SettingsError."""
    if bits not in (8, 16):
        raise SettingsError(f"visibility_bits={bits}: must be 8 or 16")
    return bits == 16 and "visibility" in aovs


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


def radius_of(depth: NDArray[np.float32], camera: Camera, kind: str, share: float = RADIUS_SHARE) -> float:
    """Return an automatic radius for a depth image: a share of the extent of the middle 96 % of its points.

    ``kind``: as :func:`settled_depth` leaves it. Raises SettingsError for window depth, whose extent is not known here.
    """
    if kind == WINDOW_DEPTH:
        raise SettingsError("radius: window depth needs a radius in scene units; give --radius, or the method's radius")
    usable = (depth > LEAST) & (depth < MOST)
    points = camera.view(depth.shape[::-1]).points(np.where(usable, depth, 0))[usable]
    if not len(points):
        return 1.0
    low, high = np.percentile(points, (2, 98), axis=0)
    return share * float(np.linalg.norm(high - low)) or 1.0
