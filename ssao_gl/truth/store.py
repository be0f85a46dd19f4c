"""Traced results on disk, under the hash of all that decides them. What is damaged is noticed, and traced anew."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError
from ..io.atomic import atomic_write, check_writable, make_folder
from ..io.cache import MOST_BYTES, prune
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..settings import as_table
from .settings import Tracing

VERSION = 1
"""Part of every key: raised whenever the same input gives other numbers."""

log = logging.getLogger("ssao_gl")


def content_key(scene: Scene, camera: Camera, size: Size, tracing: Tracing) -> str:
    """Hash of the triangles and where they are, the camera's matrices, the size and the settings; not of names or colours."""
    digest = hashlib.sha256(json.dumps([VERSION, size, as_table(tracing)], sort_keys=True).encode())
    for matrix in (camera.lens.matrix(size), camera.pose):
        digest.update(np.ascontiguousarray(matrix, np.float64).data)
    for draw in scene.meshes:
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
        with atomic_write(path) as temporary, temporary.open("wb") as file:
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
