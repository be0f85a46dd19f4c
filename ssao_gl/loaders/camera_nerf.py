"""``transforms.json`` of NeRF: poses in OpenGL axes, and one lens for all frames or one for each.

Keys are those of the original (Mildenhall et al. 2020, ``camera_angle_x``) and of instant-ngp and nerfstudio (``fl_x``, ...).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import SettingsError, warn_of_input
from ..scene.camera import Camera
from ..scene.projection import Size
from .picture_files import picture_size

DISTORTION = ("k1", "k2", "k3", "k4", "p1", "p2")


def is_transforms(content: Mapping[str, Any]) -> bool:
    """Whether this is such a file."""
    frames = content.get("frames")
    return isinstance(frames, list) and bool(frames) and isinstance(frames[0], dict) and "transform_matrix" in frames[0]


def read_transforms(content: Mapping[str, Any], path: Path, size: Size | None) -> list[Camera]:
    """Return a camera for each frame, called by its picture. Raises SettingsError, KeyError, TypeError, ValueError."""
    sizes: dict[bool, Size | None] = {}
    cameras = []
    for index, frame in enumerate(content["frames"]):
        facts = {**content, **frame}
        name = str(frame.get("file_path", index))
        if facts.get("camera_model") in ("OPENCV_FISHEYE", "EQUIRECTANGULAR"):
            raise SettingsError(f"frame '{name}': a {facts['camera_model']} is no perspective camera")
        if any(float(facts.get(key) or 0) for key in DISTORTION):
            warn_of_input(f"{path}: the lens's distortion is not modelled; undistorted pictures fit")
        if "w" in facts and "h" in facts:
            shown: Size | None = (int(facts["w"]), int(facts["h"]))
        else:
            shown = sizes.setdefault(True, _pictured(path.parent / name) or size)
        if shown is None:
            warn_of_input(f"{path}: does not say how large its pictures are, and they are not there: taken for square")
            shown = (1000, 1000)
        try:
            cameras.append(_camera(facts, shown, name))
        except SettingsError as error:
            raise SettingsError(f"frame '{name}': {str(error).removeprefix('camera: ')}") from None
    return cameras


def _camera(facts: Mapping[str, Any], size: Size, name: str) -> Camera:
    w, h = size
    if "fl_x" in facts or "camera_angle_x" in facts:
        fx = float(facts["fl_x"]) if "fl_x" in facts else w / 2 / math.tan(float(facts["camera_angle_x"]) / 2)
        fy = h / 2 / math.tan(float(facts["camera_angle_y"]) / 2) if "camera_angle_y" in facts else fx
    else:
        fx = fy = float(facts["fl_y"])
    fy = float(facts.get("fl_y", fy))
    cx, cy = float(facts.get("cx", w / 2)), float(facts.get("cy", h / 2))
    return Camera.pinhole(fx, fy, cx, cy, size, pose=facts["transform_matrix"]).named(name)


def _pictured(path: Path) -> Size | None:
    """Return the size of a frame's picture, whose suffix may be left out; None when it is not there."""
    return next((found for one in (path, path.with_name(path.name + ".png")) if (found := picture_size(one))), None)
