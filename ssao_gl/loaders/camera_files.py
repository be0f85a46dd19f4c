"""Camera files: JSON with a list of named cameras."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from ..errors import SceneError, SsaoError, encodable, near_miss, one_line
from ..io.atomic import why_unreadable
from ..scene.camera import Camera, Orthographic, Perspective, look_at

MAX_BYTES = 16 << 20


def load_cameras(path: Path | str) -> list[Camera]:
    """Every camera of a ``.cam.json`` file.

    ``{"cameras": [{"name", "eye", "target", "up", "yfov_deg" or "ortho_height", "znear", "zfar", "ao_radius"}]}``, in
    scene units and degrees; ``up``, ``znear``, ``zfar``, ``ao_radius`` and ``name`` may be left out. Raises SceneError.
    """
    path = Path(path)
    if reason := why_unreadable(path):
        raise SceneError(f"{path}: {reason}; expected a camera file, FILE.cam.json or FILE.cam.json:NAME")
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"{path}: larger than {MAX_BYTES >> 20} MiB; not a camera file")
    try:
        content = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{path}: not JSON ({one_line(error, 120)}); expected a camera file, FILE.cam.json") from None
    listed = content.get("cameras") if isinstance(content, dict) else None
    if not isinstance(listed, list) or not listed:
        raise SceneError(f"{path}: expected an object with a list 'cameras'")
    return [_camera(entry, index, path) for index, entry in enumerate(listed)]


def load_camera(spec: str) -> Camera:
    """A camera by ``FILE``, ``FILE:NAME`` or ``FILE:NUMBER`` (from 0); without a choice, the first. Raises SceneError."""
    name, _, choice = spec.rpartition(":")
    if not name or Path(spec).is_file():
        name, choice = spec, ""
    cameras = load_cameras(name)
    if not choice:
        return cameras[0]
    for camera in cameras:
        if camera.name == choice:
            return camera
    if choice.isascii() and choice.isdigit() and int(choice[:9]) < len(cameras):
        return cameras[int(choice[:9])]
    names = [camera.name for camera in cameras]
    raise SceneError(
        f"{name}: no camera '{choice}'; it has {', '.join(names)} (or a number from 0 to {len(names) - 1}).{near_miss(choice, names)}"
    )


def _camera(entry: Any, index: int, path: Path) -> Camera:
    where = f"{path}: camera {index}"
    if not isinstance(entry, dict):
        raise SceneError(f"{where} is not an object")
    where += f" ('{entry.get('name')}')" if entry.get("name") else ""
    try:
        pose = look_at(entry["eye"], entry["target"], entry.get("up", (0, 1, 0)))
        znear = float(entry.get("znear", 0.01))
        zfar = None if entry.get("zfar") is None else float(entry["zfar"])
        lens: Any
        if "ortho_height" in entry:
            lens = Orthographic(float(entry["ortho_height"]), znear, 1e4 if zfar is None else zfar)
        else:
            lens = Perspective(math.radians(float(entry["yfov_deg"])), znear, zfar)
        radius = entry.get("ao_radius")
        if radius is not None and not 0 < float(radius) < math.inf:
            raise SceneError(f"{where}: ao_radius={radius} must be above 0 and finite")
        return Camera(lens, pose, encodable(str(entry.get("name", index))), None if radius is None else float(radius))
    except KeyError as error:
        raise SceneError(f"{where}: lacks {error}.{near_miss(error.args[0], entry)}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise SceneError(f"{where}: {error}") from None
    except SsaoError as error:
        text = str(error)
        raise SceneError(text if text.startswith(str(path)) else f"{where}: {text.removeprefix('camera: ')}") from None
