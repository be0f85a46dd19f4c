"""Cameras of a batch as others read them: OpenGL's and OpenCV's matrices, NeRF's ``transforms.json``, BOP's ``scene_camera.json``.

Lengths are scene units in all of them, although BOP's own data are in millimetres.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from ..errors import SettingsError
from ..scene.camera import Camera
from .places import Place
from .rows import Row

CAMERAS, NERF, BOP = "cameras.json", "transforms.json", "scene_camera.json"
SHOWN = ("image", "color", "visibility", "normal", "depth", "bent")
"""AOVs in the order in which one stands for a view in a list of pictures."""


def write_cameras(place: Place, rows: Iterable[Row]) -> None:
    """Write three files for each scene, into its folder, of all views that are drawn. Raises FormatError."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if "camera" in row:
            groups.setdefault(row["group"], []).append(row)
    for group, views in groups.items():
        views.sort(key=lambda row: row["index"])
        _write(place, f"{group}/{CAMERAS}", {"cameras": [_entry(row) for row in views]})
        pinholes = [(row, k) for row in views if (k := _intrinsics(row)) is not None]
        if pinholes:
            _write(place, f"{group}/{NERF}", _transforms(group, pinholes))
            _write(place, f"{group}/{BOP}", {str(row["index"]): _bop(row, k) for row, k in pinholes})


def _write(place: Place, name: str, content: Mapping[str, Any]) -> None:
    place.write(name, (json.dumps(content, indent=1) + "\n").encode())


def _camera(row: Row) -> Camera:
    return Camera.from_json(row["camera"])


def _intrinsics(row: Row) -> np.ndarray | None:
    """Return the calibration matrix; None for cameras whose rays do not meet in the eye."""
    w, h = row["size"]
    try:
        return _camera(row).intrinsics((w, h))
    except SettingsError:
        return None


def _entry(row: Row) -> dict[str, Any]:
    """Return an entry of a camera file of ours, whose ``pose`` is OpenGL's camera-to-world, with what others ask for besides."""
    camera, (w, h) = _camera(row), row["size"]
    k = _intrinsics(row)
    return {
        **json.loads(row["camera"]),
        "size": [w, h],
        "opengl_projection": camera.lens.matrix((w, h)).tolist(),
        "opencv_world_to_camera": camera.world_to_camera.tolist(),
        "opencv_intrinsics": None if k is None else k.tolist(),
        "files": {aov: list(row["files"][aov]) for aov in sorted(row["files"])},
    }


def _transforms(group: str, views: Sequence[tuple[Row, np.ndarray]]) -> dict[str, Any]:
    """Return the content of ``transforms.json``, with keys as instant-ngp and nerfstudio read them, per frame."""
    frames = []
    for row, k in views:
        w, h = row["size"]
        shown = next(aov for aov in SHOWN if aov in row["files"])
        frame: dict[str, Any] = {
            "file_path": _relative(row["files"][shown][0], group),
            "transform_matrix": _camera(row).pose.tolist(),
            **{"w": w, "h": h, "fl_x": k[0, 0], "fl_y": k[1, 1], "cx": k[0, 2], "cy": k[1, 2]},
        }
        if "depth" in row["files"]:
            frame["depth_file_path"] = _relative(row["files"]["depth"][0], group)
        frames.append(frame)
    return {"camera_model": "PINHOLE", "frames": frames}


def _relative(file: str, group: str) -> str:
    return PurePosixPath(os.path.relpath(file, group)).as_posix()


def _bop(row: Row, k: np.ndarray) -> dict[str, Any]:
    extrinsic = _camera(row).world_to_camera
    return {
        "cam_K": k.ravel().tolist(),
        "depth_scale": 1.0,
        "cam_R_w2c": extrinsic[:3, :3].ravel().tolist(),
        "cam_t_w2c": extrinsic[:3, 3].tolist(),
    }
