"""Mesh files handed to trimesh with care: what a header claims is checked first, and nothing beside the file's folder is read."""

from __future__ import annotations

import bz2
import gzip
import io
import re
import tarfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO
from urllib.parse import unquote

import trimesh
from trimesh.exchange.load import mesh_formats
from trimesh.resolvers import Resolver
from trimesh.scene.scene import append_scenes

from ..camera import Camera
from ..errors import SceneError
from .gltf import open_glb, open_gltf

ARCHIVES = ("zip", "tar.gz", "tar.bz2", "bz2")
UNPACKED_FREE, UNPACKED_RATIO = 64 << 20, 50
"""An archive may unpack to 64 MiB, or to 50 times its size if that is more: text packs to a fifth, bombs to a thousandth."""
MAX_MEMBERS = 1000
MAX_HEADER = 1 << 20
MAX_MATERIALS = 4000

SIGNATURES: tuple[tuple[bytes, str, frozenset[str]], ...] = (
    (b"\x89PNG\r\n", "a PNG picture", frozenset()),
    (b"\xff\xd8\xff", "a JPEG picture", frozenset()),
    (b"%PDF", "a PDF document", frozenset()),
    (b"<!DOCTYPE html", "a web page", frozenset()),
    (b"<html", "a web page", frozenset()),
    (b"version https://git-lfs", "a Git LFS pointer (git lfs pull fetches the file)", frozenset()),
    (b"\x1f\x8b", "packed by gzip", frozenset({"tar.gz"})),
    (b"PK\x03\x04", "a ZIP archive", frozenset({"zip", "3mf", "3dxml", "zae"})),
    (b"glTF", "a GLB file", frozenset({"glb"})),
    (b"ply\n", "a PLY file", frozenset({"ply"})),
    (b"ply\r", "a PLY file", frozenset({"ply"})),
)
"""How files begin that are often misnamed: the bytes, what it is, and the formats that may begin so."""


@dataclass(frozen=True)
class Loaded:
    """What a file holds: trimesh's scene, the cameras, the format that was read (of an archive's first mesh)."""

    scene: trimesh.Scene
    kind: str
    cameras: list[Camera] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    """Files that the scene names and that could not be used: outside its folder, remote, or not there."""


def formats() -> list[str]:
    """What can be read: trimesh's mesh formats, which depend on what else is installed, and archives of them."""
    return sorted({*mesh_formats(), *ARCHIVES})


def kind_of(name: str) -> str:
    """The format by a file's name: its suffix in lower case, both suffixes of a packed tar file."""
    suffixes = [suffix.lower().lstrip(".") for suffix in PurePosixPath(name).suffixes]
    both = ".".join(suffixes[-2:])
    return both if both in ARCHIVES else (suffixes or [""])[-1]


def read(path: Path) -> Loaded:
    """Read a mesh file or an archive of some. Raises SceneError, and whatever else trimesh is led into."""
    kind = kind_of(path.name)
    with path.open("rb") as file:
        if kind in ARCHIVES:
            _check_signature(file.read(64), kind)
            return _read_archive(_unpack(path, kind))
        return _read(file, kind, path.stat().st_size, Beside(_in_folder(path.parent)))


class Beside(Resolver):
    """How trimesh gets the files that a scene names: from the scene's own folder, or its own archive, and nowhere else."""

    def __init__(self, fetch: Callable[[str], bytes | Path | None]) -> None:
        self._fetch = fetch
        self.missing: list[str] = []

    def get(self, name: str) -> bytes:
        """The content of a file. Raises SceneError."""
        found = self._find(name)
        return found.read_bytes() if isinstance(found, Path) else found

    def size(self, name: str) -> int:
        """Bytes, without reading them."""
        found = self._find(name)
        return found.stat().st_size if isinstance(found, Path) else len(found)

    def _find(self, name: str) -> bytes | Path:
        plain = str(name).strip().replace("\\", "/")
        if "://" not in plain:
            # Exporters quote names as in URLs, and leave paths of the machine that they ran on.
            for candidate in dict.fromkeys((plain, unquote(plain), plain.rsplit("/", 1)[-1])):
                found = self._fetch(candidate) if candidate else None
                if found is not None:
                    return found
        self.missing.append(str(name)[:200])
        raise SceneError(f"names the file '{str(name)[:200]}', which is not in its folder")

    def keys(self) -> list[str]:
        """Nothing: files are found by name only."""
        return []

    def write(self, name: str, data: Any) -> None:
        """Never: a scene is read."""
        raise NotImplementedError

    def namespaced(self, namespace: str) -> Beside:
        """Never: there is one folder."""
        raise NotImplementedError


def _in_folder(folder: Path) -> Callable[[str], Path | None]:
    root = folder.resolve()

    def fetch(name: str) -> Path | None:
        try:
            path = (root / name).resolve()
            return path if path.is_relative_to(root) and path.is_file() else None
        except (OSError, ValueError, RuntimeError):  # too long, a null byte, a loop of links
            return None

    return fetch


def _in_archive(files: Mapping[str, bytes], folder: PurePosixPath) -> Callable[[str], bytes | None]:
    def fetch(name: str) -> bytes | None:
        parts: list[str] = []
        for part in (folder / name).parts:
            if part != "..":
                parts.append(part)
            elif parts:
                parts.pop()
        return files.get("/".join(parts))

    return fetch


def _read(file: BinaryIO, kind: str, size: int, beside: Beside) -> Loaded:
    head = file.read(64)
    file.seek(0)
    _check_signature(head, kind)
    cameras: list[Camera] = []
    if kind in GLTF:
        file, cameras = GLTF[kind](file, size, beside.size)
    elif kind in CHECKS:
        file = CHECKS[kind](file, size)
    elif head.startswith(b"PK\x03\x04"):  # 3MF and its kin
        _check_zip(file, size)
        file.seek(0)
    # Unprocessed: trimesh would hide indices below 0, drop triangles with NaN, and weld whatever is closer than 1e-8 units.
    loaded = trimesh.load_scene(file, file_type=kind, resolver=beside, allow_remote=False, process=False)
    return Loaded(loaded, kind, cameras, beside.missing)


def _check_signature(head: bytes, kind: str) -> None:
    for begin, what, kinds in SIGNATURES:
        if head.lower().startswith(begin.lower()) and kind not in kinds:
            raise SceneError(f"is not a .{kind} file but {what}")


def _check_stl(file: BinaryIO, size: int) -> BinaryIO:
    """Binary STL is 84 bytes and 50 a triangle; anything else must be text, which begins with 'solid'."""
    head = file.read(84)
    file.seek(0)
    expected = 84 + 50 * int.from_bytes(head[80:84], "little")
    if size != expected and not head.lstrip().lower().startswith(b"solid"):
        told = f"announces {(expected - 84) // 50} triangles, {expected} bytes," if len(head) == 84 else "is too short:"
        raise SceneError(f"{told} but has {size} bytes; it is truncated or broken")
    if size == expected:
        return file
    # One solid of all: trimesh takes quadratic time to name them.
    return io.BytesIO(b"solid\n" + re.sub(rb"(?im)^[ \t]*(end)?solid.*$", b"", file.read()) + b"\nendsolid\n")


def _check_obj(file: BinaryIO, size: int) -> BinaryIO:
    """Likewise for parts of different materials, which cannot be put together."""
    materials = set(re.findall(rb"(?m)^[ \t]*usemtl[ \t]+(\S+)", file.read()))
    file.seek(0)
    if len(materials) > MAX_MATERIALS:
        raise SceneError(f"has {len(materials)} materials; at most {MAX_MATERIALS} can be read in sensible time")
    return file


def _check_ply(file: BinaryIO, size: int) -> BinaryIO:
    """Elements that a header announces must fit into the bytes after it, lists being empty."""
    head = file.read(MAX_HEADER)
    file.seek(0)
    end = head.find(b"end_header")
    if not head.startswith(b"ply") or end < 0:
        raise SceneError("has no complete PLY header ('ply' ... 'end_header'); it is truncated or broken")
    text = b"format ascii" in head[:end]
    left = size - head.find(b"\n", end) - 1
    needed, count, name = 0, 0, ""
    for line in head[:end].decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            name, count = words[1], int(words[2])
        elif words[:1] == ["property"]:
            needed += count * (2 if text else PLY_BYTES[words[2] if words[1] == "list" else words[1]])
        if count < 0 or needed > left + 1:  # the last line may lack its end
            raise SceneError(f"announces {count} of '{name}', more than its {left} bytes can hold; it is truncated or broken")
    return file


PLY_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "int64", "uint64", "float64", "long", "ulong"), 8),
}
CHECKS: Mapping[str, Callable[[BinaryIO, int], BinaryIO]] = {"stl": _check_stl, "ply": _check_ply, "obj": _check_obj}
"""What looks at a file, of some size, before trimesh does, and gives what trimesh should read."""
GLTF = {"glb": open_glb, "gltf": open_gltf}


def _check_zip(file: BinaryIO, size: int) -> list[zipfile.ZipInfo]:
    """Its members, when they unpack to a sane size; reading one stops at the size that is announced."""
    members = [member for member in zipfile.ZipFile(file).infolist() if not member.is_dir()]
    _check_unpacked(sum(member.file_size for member in members), size)
    return members


def _check_unpacked(unpacked: int, size: int) -> None:
    if unpacked > _budget(size):
        raise SceneError(
            f"unpacks to more than {UNPACKED_RATIO} times its size, so it is refused; unpack it yourself if you trust it"
        )


def _budget(size: int) -> int:
    return max(UNPACKED_FREE, UNPACKED_RATIO * size)


def _unpack(path: Path, kind: str) -> dict[str, bytes]:
    """Name -> content of every file in an archive."""
    size = path.stat().st_size
    if kind == "zip":
        with path.open("rb") as file:
            members = _check_zip(file, size)
            archive = zipfile.ZipFile(file)
            return {member.filename: archive.read(member) for member in members}
    opener: Any = gzip.open if kind == "tar.gz" else bz2.open
    with opener(path, "rb") as stream:
        data = stream.read(_budget(size) + 1)
    _check_unpacked(len(data), size)
    if kind == "bz2":
        return {path.stem: data}
    with tarfile.open(fileobj=io.BytesIO(data), mode="r:") as tar:
        entries = [entry for entry in tar.getmembers() if entry.isfile()]
        _check_unpacked(sum(entry.size for entry in entries), size)
        return {entry.name: stream.read() for entry in entries if (stream := tar.extractfile(entry)) is not None}


def _read_archive(files: Mapping[str, bytes]) -> Loaded:
    """All meshes of an archive in one scene."""
    known = mesh_formats()
    names = [
        n for n in files if kind_of(n) in known and not n.startswith("__MACOSX/") and not n.rsplit("/", 1)[-1].startswith(".")
    ]
    if not names or len(names) > MAX_MEMBERS:
        raise SceneError(f"holds {len(names)} mesh files; expected 1 to {MAX_MEMBERS}")
    parts = []
    for name in names:
        beside = Beside(_in_archive(files, PurePosixPath(name).parent))
        try:
            parts.append(_read(io.BytesIO(files[name]), kind_of(name), len(files[name]), beside))
        except SceneError as error:
            raise SceneError(f"{name}: {error}") from None
    scene = parts[0].scene if len(parts) == 1 else append_scenes([part.scene for part in parts])  # type: ignore[no-untyped-call]
    return Loaded(
        scene, parts[0].kind, [c for part in parts for c in part.cameras], [m for part in parts for m in part.missing]
    )
