"""The files that a scene names: taken from its own folder, or its own archive, and from nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from trimesh.resolvers import Resolver

from ..errors import SceneError

MAX_PARTS = 32
"""Of a path, from which leading ones are left out until a file is found."""
LARGEST = 512 << 20
"""Bytes of the materials and pictures beside a scene. A scene may name a film that happens to lie there."""


Fetch = Callable[[str], bytes | Path | None]


class FolderResolver(Resolver):
    """How trimesh gets the files that a scene names. Each is read once, and counts once, however often it is named.

    Files whose :meth:`size` was asked, and found right, may be of any size; the others have :data:`LARGEST` for all.
    """

    def __init__(self, fetch: Fetch) -> None:
        self._fetch = fetch
        self._read: dict[Path, bytes] = {}
        self._known: set[Path] = set()
        self.missing: list[str] = []
        self.edit: Callable[[str, bytes], bytes] = lambda name, content: content
        """What is made of a file before it is handed out."""

    def get(self, name: str) -> bytes:
        """The content of a file. Raises SceneError."""
        found = self._find(name)
        if isinstance(found, bytes):
            return self.edit(name, found)
        if found not in self._read:
            others = {found, *self._read} - self._known
            total = sum(path.stat().st_size for path in others)
            if total > LARGEST:
                raise SceneError(f"names files of {total >> 20} MiB; at most {LARGEST >> 20} MiB beside a scene are read")
            self._read[found] = found.read_bytes()
        return self.edit(name, self._read[found])

    def size(self, name: str) -> int:
        """Bytes, without reading them. Raises SceneError."""
        found = self._find(name)
        if isinstance(found, bytes):
            return len(found)
        self._known.add(found)
        return found.stat().st_size

    def _find(self, name: str) -> bytes | Path:
        plain = str(name).strip().replace("\\", "/")
        if "://" not in plain:
            # Exporters quote names as in URLs, and leave paths of the machine that they ran on.
            parts = plain.split("/")
            ends = ("/".join(parts[first:]) for first in range(1, min(len(parts), MAX_PARTS)))
            for candidate in dict.fromkeys((plain, unquote(plain), *ends, parts[-1])):
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

    def namespaced(self, namespace: str) -> FolderResolver:
        """Never: there is one folder."""
        raise NotImplementedError


def in_folder(folder: Path) -> Callable[[str], Path | None]:
    """Find regular files in ``folder`` and below, links followed; None for all else. Case counts only where it decides."""
    root = folder.resolve()

    def fetch(name: str) -> Path | None:
        try:
            path = (root / name).resolve()
            if not path.is_relative_to(root):
                return None
            if not path.exists() and path.parent.is_dir():
                alike = sorted(other for other in path.parent.iterdir() if other.name.lower() == path.name.lower())
                path = alike[0].resolve() if alike else path
            return path if path.is_relative_to(root) and path.is_file() else None
        except (OSError, ValueError, RuntimeError):  # too long, a null byte, a loop of links
            return None

    return fetch


def in_archive(files: Mapping[str, bytes], folder: PurePosixPath) -> Callable[[str], bytes | None]:
    """Finds members of an archive by names relative to ``folder``; None for all else."""

    def fetch(name: str) -> bytes | None:
        parts: list[str] = []
        for part in (folder / name).parts:
            if part != "..":
                parts.append(part)
            elif parts:
                parts.pop()
        return files.get("/".join(parts))

    return fetch
