"""The files that a scene is made of, and their hash: what tells a changed input without loading it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from ..errors import SceneError
from ..io.atomic import why_unreadable

NAMING = (".gltf", ".obj", ".mtl", ".nhdr", ".dae")
"""Files that name others beside them."""
MOST_BESIDE = 20_000
"""Files in the folder of a scene that are looked at."""


def content_digest(path: Path) -> str:
    """Return the hash of a scene file and of the files beside it that it names. Raises SceneError."""
    if reason := why_unreadable(path):
        raise SceneError(f"{path}: {reason}; expected a scene file")
    digest = hashlib.sha256()
    try:
        for file in files_of(path):
            digest.update(f"{file.name}\0{file.stat().st_size}\0".encode("utf-8", "surrogateescape"))
            with file.open("rb") as stream:
                while block := stream.read(1 << 20):
                    digest.update(block)
    except OSError as error:
        raise SceneError(f"{error.filename or path}: {error.strerror or error}") from None
    return digest.hexdigest()[:32]


def files_of(path: Path) -> list[Path]:
    """Return the scene file, and those in its folder and below whose names stand in it, or in one that does."""
    found, rest = [path], [path]
    while rest:
        naming = rest.pop()
        if naming.suffix.lower() in NAMING:
            text = naming.read_bytes().lower()
            for file in _beside(path):
                if file not in found and any(name in text for name in _spellings(file)):
                    found.append(file)
                    rest.append(file)
    return [path, *sorted(found[1:])]


def _beside(path: Path) -> Iterator[Path]:
    files = (file for file in path.parent.rglob("*") if file.is_file() and file != path)
    for number, file in enumerate(files):
        if number == MOST_BESIDE:
            return
        yield file


def _spellings(file: Path) -> tuple[bytes, bytes]:
    name = file.name.lower()
    return name.encode("utf-8", "surrogateescape"), quote(file.name, errors="surrogateescape").lower().encode()
