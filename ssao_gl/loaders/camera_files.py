"""Camera files of any kind that is known, told apart by what they hold; ours are JSON with a list of named cameras."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import SceneError, SsaoError, near_miss, one_line, warn_of_input
from ..io.atomic import why_unreadable
from ..scene.camera import Camera
from ..scene.projection import Size
from . import camera_bop, camera_colmap, camera_nerf

MAX_BYTES = 16 << 20


def load_cameras(path: Path | str, size: Size | None = None) -> list[Camera]:
    """Every camera of a file.

    - Ours, ``{"cameras": [{"name", "eye", "target", "up", "yfov_deg" or "ortho_height", "znear", "zfar", "ao_radius"}]}``, in
      scene units and degrees; all but ``eye``, ``target`` and one lens may be left out; ``pose`` (4, 4) may stand for the
      first two, ``intrinsics`` (fx, fy, cx, cy, width, height) or ``projection`` (4, 4) for the angle. Or one such entry alone.
    - NeRF's ``transforms.json``, COLMAP's ``cameras`` and ``images`` as ``.txt`` or ``.bin`` (name one of them, or the folder),
      BOP's ``scene_camera.json`` and ``camera.json``, and Open3D's ``PinholeCameraIntrinsic`` and ``PinholeCameraParameters``.

    size: (width, height) of the image that a camera is for, where the file does not say. Raises SceneError.
    """
    path = Path(path)
    try:
        if camera_colmap.is_colmap(path):
            return camera_colmap.read_colmap(path)
        return _from_json(path, size)
    except (KeyError, TypeError, ValueError, OverflowError, IndexError) as error:
        missing = f"lacks {error}" if isinstance(error, KeyError) else one_line(error)
        raise SceneError(f"{path}: {missing}") from None
    except SsaoError as error:
        text = str(error)
        raise SceneError(text if text.startswith(str(path)) else f"{path}: {text}") from None


def load_camera(spec: str, size: Size | None = None) -> Camera:
    """A camera by ``FILE``, ``FILE:NAME`` or ``FILE:NUMBER`` (from 0); without a choice, the first, with a warning if there are
    more. Raises SceneError."""
    name, _, choice = spec.rpartition(":")
    if not name or Path(spec).exists():
        name, choice = spec, ""
    cameras = load_cameras(name, size)
    if not choice:
        if len(cameras) > 1:
            text = f"{name}: 1 of {len(cameras)} cameras: the first one, '{cameras[0].name}', is taken; choose by FILE:NAME"
            warn_of_input(text)
        return cameras[0]
    names = [camera.name for camera in cameras]
    for known in (names, [Path(one).name for one in names], [Path(one).stem for one in names]):
        if choice in known:
            return cameras[known.index(choice)]
    if choice.isascii() and choice.isdigit() and int(choice[:9]) < len(cameras):
        return cameras[int(choice[:9])]
    listed = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
    raise SceneError(
        f"{name}: no camera '{choice}'; it has {one_line(listed)} (or a number from 0 to {len(names) - 1}).{near_miss(choice, names)}"
    )


@dataclass(frozen=True, slots=True)
class Aims:
    """What the cameras of a file are aimed at, where the scene leaves a choice: a molecule's assembly, a volume's level."""

    assembly: str | None = None
    iso: float | None = None


def read_aims(path: Path) -> Aims:
    """Return ``assembly`` and ``iso`` of a camera file of ours; nothing where there is no such file, or no such field."""
    try:
        content = json.loads(path.read_text("utf-8")) if path.is_file() and path.stat().st_size <= MAX_BYTES else {}
    except (OSError, ValueError, RecursionError):
        return Aims()  # reading its cameras says what is wrong
    table = content if isinstance(content, dict) else {}
    assembly, iso = table.get("assembly"), table.get("iso")
    return Aims(
        str(assembly) if isinstance(assembly, str | int) else None,
        float(iso) if isinstance(iso, int | float) and not isinstance(iso, bool) else None,
    )


def _from_json(path: Path, size: Size | None) -> list[Camera]:
    if reason := why_unreadable(path):
        raise SceneError(f"{path}: {reason}; expected a camera file, FILE.cam.json or FILE.cam.json:NAME")
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"{path}: larger than {MAX_BYTES >> 20} MiB; not a camera file")
    try:
        content = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{path}: not JSON ({one_line(error, 120)}); expected a camera file, FILE.cam.json") from None
    if isinstance(content, dict):
        if camera_nerf.is_transforms(content):
            return camera_nerf.read_transforms(content, path, size)
        if camera_bop.is_bop(content):
            return camera_bop.read_bop(content, path, size)
        if "intrinsic_matrix" in content or "intrinsic" in content:
            return [camera_bop.read_open3d(content)]
        if "cameras" not in content and ({"eye", "pose"} & content.keys()):
            content = {"cameras": [content]}
    listed = content.get("cameras") if isinstance(content, dict) else None
    if not isinstance(listed, list) or not listed:
        raise SceneError(f"{path}: expected an object with a list 'cameras'")
    return _named([_camera(entry, index, path) for index, entry in enumerate(listed)])


def _camera(entry: Any, index: int, path: Path) -> Camera:
    where = f"{path}: camera {index}"
    if not isinstance(entry, dict):
        raise SceneError(f"{where} is not an object")
    where += f" ('{entry.get('name')}')" if entry.get("name") else ""
    try:
        return Camera.from_json(entry)
    except SsaoError as error:
        text = str(error).removeprefix("camera: ")
        raise SceneError(f"{where}: {text}") from None


def _named(cameras: Sequence[Camera]) -> list[Camera]:
    """Return the cameras; those without a name are called by their numbers."""
    return [camera if camera.name else camera.named(str(index)) for index, camera in enumerate(cameras)]
