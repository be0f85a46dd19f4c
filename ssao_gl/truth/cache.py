"""Traced results on disk, under the hash of all that decides them. What is damaged is noticed, and traced anew."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..camera import Camera
from ..errors import FormatError
from ..files import check_writable, make_folder, written
from ..scene import Scene
from ..settings import as_table
from ..view import Size
from .settings import Tracing

VERSION = 1
"""Part of every key: raised whenever the same input gives other numbers."""

MOST_BYTES = 2 << 30
"""The folder is kept below this; what was not used for longest goes first."""

log = logging.getLogger("ssao_gl")


def default_folder() -> Path:
    """Where this platform keeps what can be made again: ``$XDG_CACHE_HOME/ssao_gl`` and its kin."""
    given = os.environ.get("XDG_CACHE_HOME")
    if given:
        return Path(given) / "ssao_gl"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ssao_gl" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "ssao_gl"
    return Path.home() / ".cache" / "ssao_gl"


def content_key(scene: Scene, camera: Camera, size: Size, tracing: Tracing) -> str:
    """Hash of the triangles and where they are, the camera's matrices, the size and the settings; not of names or colours."""
    digest = hashlib.sha256(json.dumps([VERSION, size, as_table(tracing)], sort_keys=True).encode())
    for matrix in (camera.lens.matrix(size), camera.pose):
        digest.update(np.ascontiguousarray(matrix, np.float64).data)
    for draw in scene.draws:
        normals = draw.normals if tracing.normals == "shading" else None
        for array in (draw.positions, draw.triangles, draw.transforms, normals):
            # Shapes too: two arrays must not pass for another two of the same bytes in a row.
            digest.update(repr(None if array is None else array.shape).encode())
            if array is not None:
                digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()[:32]


class Store:
    """The two files of one key: the result, and what is traced so far."""

    def __init__(self, folder: Path, key: str) -> None:
        self._result = folder / f"truth-{key}.npz"
        self._partial = folder / f"truth-{key}.part.npz"

    def result(self) -> dict[str, Any] | None:
        """What :meth:`finish` wrote, or None."""
        found = _read(self._result)
        if found is not None:
            with suppress(OSError):
                os.utime(self._result)  # used now: see prune
        return found

    def partial(self) -> dict[str, Any] | None:
        """What :meth:`keep` wrote last, or None."""
        return _read(self._partial)

    def keep(self, arrays: dict[str, Any]) -> None:
        """Write what is traced so far."""
        _write(self._partial, arrays)

    def finish(self, arrays: dict[str, Any]) -> None:
        """Write the result, drop what was traced so far."""
        _write(self._result, arrays)
        with suppress(OSError):
            self._partial.unlink(missing_ok=True)
        prune(self._result.parent, MOST_BYTES)


def store(folder: Path, key: str) -> Store:
    """The store of ``key`` in ``folder``, which is made. Raises FormatError at once when nothing can be written there."""
    make_folder(folder)
    check_writable(folder, folder=True)
    return Store(folder, key)


def prune(folder: Path, most: int) -> None:
    """Remove the files that were not used for longest until the rest take at most ``most`` bytes."""
    files = []
    # With a dot: what a process that was killed had begun to write.
    for path in [*folder.glob("truth-*.npz"), *folder.glob(".truth-*.npz")]:
        with suppress(OSError):
            files.append((path.stat().st_mtime, path.stat().st_size, path))
    over = sum(size for _, size, _ in files) - most
    for _, size, path in sorted(files):
        if over <= 0:
            return
        with suppress(OSError):
            path.unlink()
            over -= size


def _digest(arrays: dict[str, Any]) -> str:
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _write(path: Path, arrays: dict[str, Any]) -> None:
    """A disk that fills up costs the file, with a warning, and not what was traced."""
    try:
        with written(path) as temporary, temporary.open("wb") as file:
            np.savez(file, digest=_digest(arrays), **arrays)
    except FormatError as error:
        log.warning("%s; going on without", error)


def _read(path: Path) -> dict[str, Any] | None:
    """The arrays of a file, scalars as numbers; None when there is none, or, with a warning, when it is damaged."""
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
        if str(arrays.pop("digest")) != _digest(arrays):
            raise ValueError("its content has changed")
    except Exception as error:  # zip files break in many ways
        log.warning("%s is damaged (%s); tracing anew", path, " ".join(str(error).split())[:120] or type(error).__name__)
        return None
    return {name: array.item() if array.ndim == 0 else array for name, array in arrays.items()}
