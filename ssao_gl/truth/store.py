"""Traced results on disk, under the hash of all that decides them. What is damaged is noticed, and traced anew."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..io.atomic import check_writable, make_folder
from ..io.cache import prune, read_cached, write_cached
from ..io.fingerprint import add_arrays, add_thing
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..settings import as_table
from .settings import Tracing

VERSION = 2
"""Part of every key: raised whenever the same input gives other numbers."""


def content_key(scene: Scene, camera: Camera, size: Size, tracing: Tracing) -> str:
    """Return the hash of what is drawn and where it is, the camera, the size and the settings; not of names or colours."""
    digest = hashlib.sha256(json.dumps([VERSION, size, as_table(tracing)], sort_keys=True).encode())
    add_arrays(digest, (np.asarray(camera.lens.matrix(size), np.float64), np.asarray(camera.pose, np.float64)))
    for thing in scene.drawn:
        add_thing(digest, thing, normals=tracing.normals == "shading", colors=False)
    return digest.hexdigest()[:32]


class Store:
    """The two files of one key: the result, and what is traced so far."""

    def __init__(self, folder: Path, key: str, kind: str = "truth") -> None:
        self._kind = kind
        self._result = folder / f"{kind}-{key}.npz"
        self._partial = folder / f"{kind}-{key}.part.npz"

    def result(self) -> dict[str, Any] | None:
        """Return what :meth:`finish` wrote, or None."""
        found = _read(self._result)
        if found is not None:
            with suppress(OSError):
                os.utime(self._result)  # used now: see prune
        return found

    def partial(self) -> dict[str, Any] | None:
        """Return what :meth:`keep` wrote last, or None."""
        return _read(self._partial)

    def keep(self, arrays: dict[str, Any]) -> None:
        """Write what is traced so far."""
        _write(self._partial, arrays)

    def finish(self, arrays: dict[str, Any]) -> None:
        """Write the result, drop what was traced so far."""
        _write(self._result, arrays)
        with suppress(OSError):
            self._partial.unlink(missing_ok=True)
        prune(self._result.parent, self._kind)


def store(folder: Path, key: str, kind: str = "truth") -> Store:
    """Return the store of ``key`` among files of a ``kind`` in ``folder``, which is made. Raises FormatError at once when nothing can be written
    there."""
    make_folder(folder)
    check_writable(folder, folder=True)
    return Store(folder, key, kind)


def _digest(arrays: dict[str, Any]) -> str:
    digest = hashlib.sha256(repr(sorted(arrays)).encode())
    add_arrays(digest, (np.asarray(arrays[name]) for name in sorted(arrays)))
    return digest.hexdigest()


def _write(path: Path, arrays: dict[str, Any]) -> None:
    """Write arrays with their digest. A disk that fills up costs the file, with a warning, and not what was traced."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez(file, digest=_digest(arrays), **arrays)

    write_cached(path, write)


def _read(path: Path) -> dict[str, Any] | None:
    """Return the arrays of a file, scalars as numbers; None when there is none, or, with a warning, when it is damaged."""
    return read_cached(path, _arrays)


def _arrays(path: Path) -> dict[str, Any]:
    # The file is ours to close: of one that is cut, numpy leaves it open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
        arrays = {name: content[name] for name in content.files}
    if str(arrays.pop("digest")) != _digest(arrays):
        raise ValueError("its content has changed")
    return {name: array.item() if array.ndim == 0 else array for name, array in arrays.items()}
