"""Arrays that grow tile by tile on disk, in a folder that outlives the process, so that an interrupted picture goes on.

The arrays are plain NPY files, written by seeking and not through a memory map: on a full disk a write fails in words,
where a map ends the process. A small JSON file beside them says how many tiles are there, and of which picture.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..io.atomic import atomic_write, make_folder
from ..io.locks import lock
from ..scene.projection import Size
from .layout import PixelRect

STATE, LOCK = "tiles.json", "lock"
BAND_BYTES = 1 << 24
"""Rows are read back in bands of about so many bytes."""


class TileCanvas:
    """The working folder of a picture of ``size``; ``identity`` is a hash of all that decides its pixels.

    ``done`` tiles are there from before when the folder holds that identity; else it is begun anew. Leave it with
    ``with``: a folder without a single tile is removed. ``output`` is what messages name, if not the folder. Raises FormatError when
    the folder cannot be written, or when another process is at work in it.
    """

    def __init__(self, folder: Path, size: Size, identity: str, output: Path | None = None) -> None:
        self.folder, self.size = folder, size
        self.done = 0
        self.notes: dict[str, Any] = {}
        """What the caller wants to find again, JSON values."""
        self._identity = identity
        self._named = output or folder
        make_folder(folder)
        self._lock = _locked(folder)
        state = read_state(folder / STATE)
        names = state.get("arrays", [])
        if state.get("identity") == identity and all(self._whole(name) for name in names):
            self.done, self.notes = state["done"], state["notes"]
        else:
            for path in folder.glob("*.npy"):
                path.unlink()

    def add(self, inner: PixelRect, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Put the next tile's arrays (h, w, ...), row 0 on top, to their place; it counts once it is all there."""
        try:
            self._make_room(arrays)
            for name, array in arrays.items():
                self._put(name, inner, array)
        except OSError as error:
            kept = f"; the {self.done} tiles before are kept, and the same command goes on from there" if self.done else ""
            raise FormatError(f"cannot write {self._named}: {error.strerror or error}{kept}") from None
        self.done += 1
        state = {"identity": self._identity, "arrays": list(arrays), "done": self.done, "notes": self.notes}
        with atomic_write(self.folder / STATE) as temporary:
            temporary.write_text(json.dumps(state), "utf-8")

    def path(self, name: str) -> Path:
        """Return the NPY file of an array."""
        return self.folder / f"{name}.npy"

    def bands(self, name: str) -> Iterator[NDArray[Any]]:
        """Yield the rows of an array from the top, some at a time: read, so that they do not pile up in memory as mapped
        ones do."""
        with self.path(name).open("rb") as file:
            shape, dtype = _header(file)
            count = self.band(name)
            for top in range(0, shape[0], count):
                rows = min(count, shape[0] - top)
                yield np.fromfile(file, dtype, rows * int(np.prod(shape[1:]))).reshape(rows, *shape[1:])

    def band(self, name: str) -> int:
        """How many rows a band has."""
        with self.path(name).open("rb") as file:
            shape, dtype = _header(file)
        return max(1, BAND_BYTES // (int(np.prod(shape[1:])) * dtype.itemsize))

    def remove(self) -> None:
        """Remove the folder: the picture is where it belongs."""
        self._lock.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _make_room(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Make the files of the arrays that have none yet, holes first. Raises OSError when the disk has no room for them."""
        w, h = self.size
        missing = {name: array for name, array in arrays.items() if not self.path(name).exists()}
        need = sum(w * h * array[0, 0].nbytes for array in missing.values())
        free = shutil.disk_usage(self.folder).free
        if need > free:
            raise OSError(
                f"{w}x{h} pixels take {need / 2**30:.1f} GiB while they are drawn, and {free / 2**30:.1f} GiB are free"
            )
        for name, array in missing.items():
            np.lib.format.open_memmap(self.path(name), "w+", array.dtype, (h, w, *array.shape[2:]))

    def _put(self, name: str, inner: PixelRect, array: NDArray[Any]) -> None:
        """Row by row; rows count from the top here, and from the bottom in ``inner``."""
        with self.path(name).open("r+b") as file:
            _header(file)
            start, pixel = file.tell(), array[0, 0].nbytes
            top = self.size[1] - inner.y - inner.h
            for row, values in enumerate(np.ascontiguousarray(array)):
                file.seek(start + ((top + row) * self.size[0] + inner.x) * pixel)
                file.write(values.data)

    def _whole(self, name: str) -> bool:
        """Whether the file of an array is there, in its full length."""
        try:
            with self.path(name).open("rb") as file:
                shape, dtype = _header(file)
                return self.path(name).stat().st_size == file.tell() + int(np.prod(shape)) * dtype.itemsize
        except (OSError, ValueError):
            return False

    def __enter__(self) -> TileCanvas:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if not self.done:
            self.remove()
        self._lock.close()


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Make a folder for outputs, which does not stay when nothing came into it."""
    new = not folder.exists()
    make_folder(folder)
    try:
        yield
    finally:
        if new:
            with suppress(OSError):
                folder.rmdir()


def _header(file: BinaryIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an NPY file, which is then at its first value."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    return shape, dtype


def read_state(path: Path) -> dict[str, Any]:
    """Return what was noted; nothing when that is missing or damaged."""
    try:
        state = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return state if isinstance(state, dict) else {}


def _locked(folder: Path) -> BinaryIO:
    """Return an open file that this process alone has locked; the lock goes with the process, however it ends."""
    try:
        handle = os.open(folder / LOCK, os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        file = os.fdopen(handle, "wb")
    except OSError as error:
        raise FormatError(f"cannot write {folder}: {error.strerror or error}") from None
    try:
        lock(file.fileno(), folder)
    except FormatError:
        file.close()
        raise
    return file
