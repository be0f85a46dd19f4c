"""Mesh files handed to trimesh with care: what a header claims is checked first, and nothing beside the file's folder is read."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import BinaryIO

import trimesh
from trimesh.exchange.load import mesh_formats
from trimesh.scene.scene import append_scenes

from ..errors import SceneError, near_miss
from ..scene.camera import Camera
from .archives import ARCHIVES, rezip, unpack, unzip
from .gltf import open_glb, open_gltf
from .header_checks import CHECKS, check_signature
from .resolver import FolderResolver, in_archive, in_folder
from .xml_checks import check_3mf, check_dae

GUARDED = ("glb", "gltf", "obj", "ply", "stl", "stl_ascii", "off", "xyz", "3mf", "dae", "zae")
"""Formats whose files are checked here first. trimesh has readers for more, which a broken file may crash or keep busy."""
NEEDS = {"3mf": "lxml", "dae": "pycollada", "zae": "pycollada"}
"""Packages without which trimesh has no reader for a format."""
GLTF = {"glb": open_glb, "gltf": open_gltf}
MAX_MEMBERS = 1000
"""Meshes in an archive."""


@dataclass(frozen=True)
class Loaded:
    """What a file holds: trimesh's scene, the cameras, the format that was read (of an archive's first mesh)."""

    scene: trimesh.Scene
    kind: str
    cameras: list[Camera] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    """Files that the scene names and that could not be used: outside its folder, remote, or not there."""


def formats() -> list[str]:
    """What can be read here, and archives of it: some formats depend on what else is installed."""
    return sorted({*(set(GUARDED) & mesh_formats()), *ARCHIVES})


def kind_of(name: str) -> str:
    """The format by a file's name: its suffix in lower case, both suffixes of a packed tar file."""
    suffixes = [suffix.lower().lstrip(".") for suffix in PurePosixPath(name).suffixes]
    both = ".".join(suffixes[-2:])
    return both if both in ARCHIVES else (suffixes or [""])[-1]


def read(path: Path) -> Loaded:
    """Read a mesh file or an archive of some. Raises SceneError, and whatever else trimesh is led into."""
    kind, size = kind_of(path.name), path.stat().st_size
    _check_known(kind)
    with path.open("rb") as file:
        if kind not in ARCHIVES:
            return _read(file, kind, size, size, FolderResolver(in_folder(path.parent)))
        check_signature(file.read(64), kind)
        file.seek(0)
        return _read_archive(unpack(file, kind, size, path.name), size)


def _check_known(kind: str) -> None:
    if kind in formats():
        return
    if kind in NEEDS:
        raise SceneError(f"reading .{kind} files needs a package: pip install {NEEDS[kind]}")
    if kind in mesh_formats():
        raise SceneError(
            f"format '.{kind}' is not read: trimesh's reader of it cannot be guarded against broken files; convert it to GLB"
        )
    raise SceneError(f"unknown mesh format '.{kind}'; can be read: {', '.join(formats())}.{near_miss(kind, formats())}")


def _read(file: BinaryIO, kind: str, size: int, packed: int, beside: FolderResolver) -> Loaded:
    """``packed``: bytes of the file on disk, which says how much may come out of an archive in an archive."""
    head = file.read(64)
    file.seek(0)
    check_signature(head, kind)
    cameras: list[Camera] = []
    if kind in GLTF:
        file, cameras = GLTF[kind](file, size, beside.size)
    elif kind in CHECKS:
        file = CHECKS[kind](file, size)
    elif kind == "dae":
        file = io.BytesIO(check_dae(file.read()))
    else:
        files = unzip(file, packed)
        (check_3mf if kind == "3mf" else _check_zae)(files)
        file = rezip(files)
    # Unprocessed: trimesh would hide indices below 0, drop triangles with NaN, and weld whatever is closer than 1e-8 units.
    loaded = trimesh.load_scene(file, file_type=kind, resolver=beside, allow_remote=False, process=False)
    return Loaded(loaded, kind, cameras, beside.missing)


def _check_zae(files: Mapping[str, bytes]) -> None:
    for name, content in files.items():
        if name.lower().endswith(".dae"):
            check_dae(content)


def _read_archive(files: Mapping[str, bytes], packed: int) -> Loaded:
    """All meshes of an archive in one scene."""
    known = set(formats()) - set(ARCHIVES)
    names = [
        n for n in files if kind_of(n) in known and not n.startswith("__MACOSX/") and not n.rsplit("/", 1)[-1].startswith(".")
    ]
    if not names or len(names) > MAX_MEMBERS:
        raise SceneError(f"holds {len(names)} mesh files; expected 1 to {MAX_MEMBERS}")
    parts = []
    for name in names:
        beside = FolderResolver(in_archive(files, PurePosixPath(name).parent))
        try:
            parts.append(_read(io.BytesIO(files[name]), kind_of(name), len(files[name]), packed, beside))
        except SceneError as error:
            raise SceneError(f"{name}: {error}") from None
    scene = parts[0].scene if len(parts) == 1 else append_scenes([part.scene for part in parts])  # type: ignore[no-untyped-call]
    return Loaded(
        scene, parts[0].kind, [c for part in parts for c in part.cameras], [m for part in parts for m in part.missing]
    )
