"""Mesh files by format: what a header claims is checked first, and nothing beside the file's folder is read."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.load import mesh_formats

from ..errors import SceneError, near_miss
from ..scene.camera import Camera
from ..scene.lamps import Lamp
from ..scene.model import Mesh
from .archives import ARCHIVES, SINGLE, rezip, unpack, unzip
from .gltf import OPEN, read_gltf
from .header_checks import CHECKS, check_signature
from .mtl_lines import without_options
from .notes import Notes
from .read_options import ReadOptions
from .resolver import Fetch, FolderResolver, in_archive, in_folder
from .stl_colors import face_colors
from .threemf_colors import object_colors
from .trimesh_materials import TrimeshLooks
from .trimesh_scenes import meshes_of
from .xml_checks import check_3mf, check_dae

GUARDED = ("glb", "gltf", "obj", "ply", "stl", "stl_ascii", "off", "xyz", "3mf", "dae", "zae")
"""Formats whose files are checked here first. trimesh has readers for more, which a broken file may crash or keep busy."""
NEEDS = {"3mf": "lxml", "dae": "pycollada", "zae": "pycollada"}
"""Packages without which trimesh has no reader for a format."""
MAX_MEMBERS = 1000
"""Meshes in an archive."""


@dataclass(frozen=True)
class Loaded:
    """What a file holds: meshes, cameras, lamps, the format that was read (of an archive's first mesh)."""

    meshes: list[Mesh]
    kind: str
    cameras: list[Camera] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)


def formats() -> list[str]:
    """What can be read here, and archives of it: some formats depend on what else is installed."""
    return sorted({*(set(GUARDED) & mesh_formats()), *ARCHIVES})


def kind_of(name: str) -> str:
    """The format by a file's name: its suffix in lower case, both suffixes of a packed tar file."""
    suffixes = [suffix.lower().lstrip(".") for suffix in PurePosixPath(name).suffixes]
    both = ".".join(suffixes[-2:])
    return both if both in ARCHIVES else (suffixes or [""])[-1]


def read(path: Path, options: ReadOptions, notes: Notes) -> Loaded:
    """Read a mesh file or an archive of some. Raises SceneError, and whatever else trimesh is led into."""
    kind, size = kind_of(path.name), path.stat().st_size
    _check_known(kind)
    with path.open("rb") as file:
        if kind not in ARCHIVES:
            return _Reader(options, notes, size).read(file, kind, size, FolderResolver(in_folder(path.parent)))
        check_signature(file.read(64), kind)
        file.seek(0)
        files = unpack(file, kind, size, path.name)
        # What is packed by itself still has its pictures and materials beside it.
        fetch = in_folder(path.parent) if kind in SINGLE else None
        return _Reader(options, notes, size).archive(files, fetch)


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


@dataclass(frozen=True)
class _Reader:
    """packed: bytes of the file on disk, which says how much may come out of an archive in an archive."""

    options: ReadOptions
    notes: Notes
    packed: int

    def read(self, file: BinaryIO, kind: str, size: int, beside: FolderResolver) -> Loaded:
        """One mesh file."""
        head = file.read(64)
        file.seek(0)
        check_signature(head, kind)
        if kind in OPEN:
            document = OPEN[kind](file, size, beside)
            document.notes = self.notes
            meshes, cameras, lamps = read_gltf(document, self.options)
            loaded = Loaded(meshes, kind, cameras, lamps)
        elif self.options.animation is not None:
            raise SceneError(f"has no animations, as no .{kind} file has; leave out '{self.options.animation}'")
        else:
            loaded = Loaded(self._by_trimesh(file, kind, size, beside), kind)
        for name in dict.fromkeys(beside.missing):
            self.notes.add(f"drawn without '{name}', which is not in its folder")
        return loaded

    def _by_trimesh(self, file: BinaryIO, kind: str, size: int, beside: FolderResolver) -> list[Mesh]:
        beside.edit = partial(without_options, notes=self.notes)
        header = file.read(80)
        colors: list[tuple[int, NDArray[np.uint8] | None]] = []
        file.seek(0)
        if kind in CHECKS:
            file = CHECKS[kind](file, size)
        elif kind == "dae":
            file = io.BytesIO(check_dae(file.read()))
        else:
            files = unzip(file, self.packed)
            (check_3mf if kind == "3mf" else _check_zae)(files)
            colors = object_colors(files, self.notes) if kind == "3mf" else []
            file = rezip(files)
        # Unprocessed: trimesh would hide indices below 0, drop triangles with NaN, and weld whatever is closer than 1e-8 units.
        scene = trimesh.load_scene(file, file_type=kind, resolver=beside, allow_remote=False, process=False)
        if kind == "3mf":
            _paint(list(scene.geometry.values()), colors, self.notes)
        if kind == "stl":
            for mesh in scene.geometry.values():
                words = mesh.face_attributes.get("stl") if isinstance(mesh, trimesh.Trimesh) else None
                found = None if words is None else face_colors(header, np.asarray(words, np.uint16))
                if found is not None:
                    mesh.visual.face_colors = found
        looks = TrimeshLooks(self.notes, beside, encoded=kind in ("dae", "zae"))
        return meshes_of(scene, self.options, self.notes, soup=True, looks=looks)

    def archive(self, files: Mapping[str, bytes], fetch: Fetch | None = None) -> Loaded:
        """All meshes of an archive in one scene; ``fetch`` finds what they name, None: in the archive."""
        known = set(formats()) - set(ARCHIVES)
        names = [
            n
            for n in files
            if kind_of(n) in known and not n.startswith("__MACOSX/") and not n.rsplit("/", 1)[-1].startswith(".")
        ]
        if not names or len(names) > MAX_MEMBERS:
            raise SceneError(f"holds {len(names)} mesh files; expected 1 to {MAX_MEMBERS}")
        parts = []
        for name in names:
            beside = FolderResolver(fetch or in_archive(files, PurePosixPath(name).parent))
            try:
                parts.append(self.read(io.BytesIO(files[name]), kind_of(name), len(files[name]), beside))
            except SceneError as error:
                raise SceneError(f"{name}: {error}") from None
        meshes = [mesh for part in parts for mesh in part.meshes]
        cameras, lamps = [c for part in parts for c in part.cameras], [lamp for part in parts for lamp in part.lamps]
        return Loaded(meshes, parts[0].kind, cameras, lamps)


def _paint(meshes: list[Any], colors: list[tuple[int, NDArray[np.uint8] | None]], notes: Notes) -> None:
    """Give the objects of a 3MF file, in their order, the colours of their triangles."""
    known: list[Any] = [mesh for mesh in meshes if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    if [len(mesh.faces) for mesh in known] == [count for count, _ in colors]:
        for mesh, (_, found) in zip(known, colors, strict=True):
            if found is not None:
                mesh.visual.face_colors = found
    elif any(found is not None for _, found in colors):
        notes.add("its colours are not read, for its objects are spread over several parts")


def _check_zae(files: Mapping[str, bytes]) -> None:
    for name, content in files.items():
        if name.lower().endswith(".dae"):
            check_dae(content)
