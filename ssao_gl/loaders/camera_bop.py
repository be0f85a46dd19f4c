"""Cameras of BOP data sets (``scene_camera.json``, ``camera.json``; bop.felk.cvut.cz/datasets) and of Open3D's JSON files.

Poses are in OpenCV axes, in the unit of the file: millimetres for BOP.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SettingsError, warn_of_input
from ..scene.camera import Camera
from ..scene.projection import Size
from .picture_files import picture_size


def is_bop(content: Mapping[str, Any]) -> bool:
    """Whether this is one of BOP's two files."""
    first = next(iter(content.values()), None)
    return (isinstance(first, dict) and "cam_K" in first) or {"fx", "fy", "cx", "cy"} <= content.keys()


def read_bop(content: Mapping[str, Any], path: Path, size: Size | None) -> list[Camera]:
    """Return a camera for each image, called by its number. Raises SettingsError, KeyError, TypeError, ValueError."""
    if "fx" in content:
        fx, fy, cx, cy = (float(content[name]) for name in ("fx", "fy", "cx", "cy"))
        return [Camera.pinhole(fx, fy, cx, cy, _stated(content) or size or _twice(cx, cy, path)).named("camera")]
    cameras = []
    for number, entry in content.items():
        k = np.asarray(entry["cam_K"], np.float64).reshape(3, 3)
        shown = _beside(path, number) or size or _twice(k[0, 2], k[1, 2], path)
        extrinsic = None
        if "cam_R_w2c" in entry:
            turn = np.asarray(entry["cam_R_w2c"], np.float64).reshape(3, 3)
            extrinsic = np.column_stack([turn, np.asarray(entry.get("cam_t_w2c", (0, 0, 0)), np.float64).reshape(3)])
        try:
            cameras.append(Camera.from_intrinsics(k, shown, world_to_camera=extrinsic).named(str(number)))
        except SettingsError as error:
            raise SettingsError(f"image {number}: {str(error).removeprefix('camera: ')}") from None
    return cameras


def read_open3d(content: Mapping[str, Any]) -> Camera:
    """Return the camera of ``PinholeCameraIntrinsic`` or ``PinholeCameraParameters``, whose matrices are column-major."""
    lens = content.get("intrinsic", content)
    k = np.asarray(lens["intrinsic_matrix"], np.float64).reshape(3, 3).T
    extrinsic = np.asarray(content["extrinsic"], np.float64).reshape(4, 4).T if "extrinsic" in content else None
    return Camera.from_intrinsics(k, (int(lens["width"]), int(lens["height"])), world_to_camera=extrinsic).named("open3d")


def _stated(content: Mapping[str, Any]) -> Size | None:
    return (int(content["width"]), int(content["height"])) if {"width", "height"} <= content.keys() else None


def _beside(path: Path, number: str) -> Size | None:
    """Return the size of images as the data set's folders tell it: its pictures, or a ``camera.json`` above."""
    for folder in ("rgb", "gray", "depth", "rgb_cam1"):
        for suffix in (".png", ".jpg", ".tif"):
            if found := picture_size(path.parent / folder / f"{number.zfill(6)}{suffix}"):
                return found
    for above in (path.parent, path.parent.parent, path.parent.parent.parent):
        try:
            return _stated(json.loads((above / "camera.json").read_text("utf-8")))
        except (OSError, ValueError, TypeError, AttributeError, RecursionError):
            continue
    return None


def _twice(cx: float, cy: float, path: Path) -> Size:
    size = max(1, round(2 * cx)), max(1, round(2 * cy))
    text = f"{path}: does not say how large its images are: taken for {size[0]}x{size[1]}, whose middle is the principal point"
    warn_of_input(text)
    return size
