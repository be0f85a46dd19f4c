"""Reconstructions of COLMAP: ``cameras`` and ``images``, as text or binary (colmap.github.io/format.html).

Poses are world-to-camera in OpenCV axes; quaternions are w, x, y, z.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..errors import SceneError, SettingsError, warn_of_input
from ..io.atomic import why_unreadable
from ..scene.camera import Camera
from ..scene.lens import Pinhole

MODELS = (
    ("SIMPLE_PINHOLE", 3), ("PINHOLE", 4), ("SIMPLE_RADIAL", 4), ("RADIAL", 5), ("OPENCV", 8), ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12), ("FOV", 5), ("SIMPLE_RADIAL_FISHEYE", 4), ("RADIAL_FISHEYE", 5), ("THIN_PRISM_FISHEYE", 12),
)  # fmt: skip
"""Name and number of parameters, by the number that binary files give."""
ONE_FOCAL = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL")
"""Models whose parameters are f, cx, cy, ...; all others' are fx, fy, cx, cy, ..."""
CURVED = ("OPENCV_FISHEYE", "FOV", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "THIN_PRISM_FISHEYE")
"""Models that no perspective is close to."""
MOST_NAME = 4096
POINT_BYTES = 24

NAMES = ("cameras.txt", "images.txt", "cameras.bin", "images.bin")


def is_colmap(path: Path) -> bool:
    """Whether this is a file of a reconstruction, or its folder."""
    return path.name in NAMES or (path.is_dir() and any((path / name).is_file() for name in NAMES))


def read_colmap(path: Path) -> list[Camera]:
    """Return a camera for each image, called by its name, in the order of the file.

    Raises SceneError, SettingsError, ValueError.
    """
    folder = path if path.is_dir() else path.parent
    suffix = (
        path.suffix
        if not path.is_dir()
        else next(n[-4:] for n in ("images.bin", "images.txt", *NAMES) if (folder / n).is_file())
    )
    lenses_file, poses_file = folder / f"cameras{suffix}", folder / f"images{suffix}"
    for file in (lenses_file, poses_file):
        if reason := why_unreadable(file):
            raise SceneError(f"{file}: {reason}; a reconstruction has cameras{suffix} and images{suffix}")
    try:
        lenses = dict(_lenses_of_bytes(lenses_file) if suffix == ".bin" else _lenses_of_text(lenses_file))
        poses = list(_poses_of_bytes(poses_file) if suffix == ".bin" else _poses_of_text(poses_file))
    except (struct.error, UnicodeDecodeError, IndexError):
        raise SceneError(f"{folder}: cameras{suffix} or images{suffix} is damaged or cut short") from None
    cameras = []
    for number, numbers, name in poses:
        if number not in lenses:
            raise SceneError(f"{poses_file}: image '{name}' names camera {number}, which {lenses_file.name} lacks")
        try:
            lens = lenses[number]
            size = (lens.width, lens.height)
            extrinsic = _extrinsic(numbers)
            cameras.append(Camera.pinhole(lens.fx, lens.fy, lens.cx, lens.cy, size, world_to_camera=extrinsic).named(name))
        except SettingsError as error:
            raise SettingsError(f"image '{name}': {str(error).removeprefix('camera: ')}") from None
    if not cameras:
        raise SceneError(f"{poses_file}: has no images")
    return cameras


def _extrinsic(numbers: tuple[float, ...]) -> np.ndarray:
    """Return (3, 4) of w, x, y, z and a translation. Raises SettingsError for a quaternion of no length."""
    w, x, y, z = np.asarray(numbers[:4]) / (np.linalg.norm(numbers[:4]) or np.nan)
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.column_stack([turn, numbers[4:7]])


def _lens(model: str, width: int, height: int, numbers: tuple[float, ...], file: Path) -> Pinhole:
    if model in CURVED:
        raise SceneError(f"{file}: {model} is no perspective camera; undistort the images first (colmap image_undistorter)")
    single = model in ONE_FOCAL
    fx, fy, cx, cy = (numbers[0], *numbers[:3]) if single else numbers[:4]
    if any(numbers[3 if single else 4 :]):
        text = f"{file}: the lens's distortion ({model}) is not modelled; undistorted pictures fit"
        warn_of_input(text)
    return Pinhole(fx, fy, cx, cy, width, height)


def _lenses_of_text(file: Path) -> Iterator[tuple[int, Pinhole]]:
    for line in _lines(file):
        if words := line.split():
            counts = dict(MODELS)
            if words[1] not in counts or len(words) < 4 + counts[words[1]]:
                raise SceneError(f"{file}: cannot read '{line[:60]}'; expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS...")
            numbers = tuple(map(float, words[4 : 4 + counts[words[1]]]))
            yield int(words[0]), _lens(words[1], int(words[2]), int(words[3]), numbers, file)


def _poses_of_text(file: Path) -> Iterator[tuple[int, tuple[float, ...], str]]:
    lines = _lines(file)
    for line in lines:
        words = line.split(maxsplit=9)
        if not words:
            continue
        if len(words) < 10:
            raise SceneError(f"{file}: cannot read '{line[:60]}'; expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")
        yield int(words[8]), tuple(map(float, words[1:8])), words[9].strip()
        next(lines, None)  # of its points, which may be empty


def _lines(file: Path) -> Iterator[str]:
    with file.open(encoding="utf-8") as stream:
        yield from (line.rstrip("\r\n") for line in stream if not line.startswith("#"))


def _lenses_of_bytes(file: Path) -> Iterator[tuple[int, Pinhole]]:
    with file.open("rb") as stream:
        for _ in range(_take(stream, "<Q")[0]):
            number, kind, width, height = _take(stream, "<iiQQ")
            if not 0 <= kind < len(MODELS):
                raise SceneError(f"{file}: camera model {kind} is not known")
            model, count = MODELS[kind]
            yield number, _lens(model, width, height, _take(stream, f"<{count}d"), file)


def _poses_of_bytes(file: Path) -> Iterator[tuple[int, tuple[float, ...], str]]:
    length = file.stat().st_size
    with file.open("rb") as stream:
        for _ in range(_take(stream, "<Q")[0]):
            _, *numbers, camera = _take(stream, "<i7di")
            name = bytearray()
            while (byte := stream.read(1)) != b"\0":
                if not byte or len(name) > MOST_NAME:
                    raise SceneError(f"{file}: is damaged or cut short")
                name += byte
            points = _take(stream, "<Q")[0]
            if stream.tell() + POINT_BYTES * points > length:
                raise SceneError(f"{file}: is damaged or cut short")
            stream.seek(POINT_BYTES * points, 1)
            yield camera, tuple(numbers), name.decode("utf-8")


def _take(stream: BinaryIO, form: str) -> tuple[Any, ...]:
    return struct.unpack(form, stream.read(struct.calcsize(form)))
