"""One file or folder for all arrays: Zarr, whose chunks processes write side by side, and HDF5, which one process writes.

Arrays are called as files in a folder would be, without suffix: ``scene/camera/visibility``.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError, one_line
from ..io.atomic import atomic_write, check_writable
from .places import Array, Folder


def _stem(name: str) -> str:
    return str(Path(name).with_suffix("").as_posix())


@dataclass(frozen=True)
class Zarr(Folder):
    """A Zarr hierarchy in a folder, an array a chunk; all but the arrays is in a folder beside it."""

    path: Path

    def save(self, name: str, array: Array, texts: Mapping[str, str]) -> int:
        try:
            _zarr().create_array(
                str(self.path), name=_stem(name), data=np.ascontiguousarray(array), chunks=array.shape, overwrite=True
            )
        except (OSError, ValueError) as error:
            raise FormatError(f"cannot write {self.path}: {getattr(error, 'strerror', None) or one_line(error)}") from None
        return int(array.nbytes)

    def holds(self, name: str, size: int) -> bool:
        with suppress(Exception):  # what is damaged is not held
            return bool(_zarr().open_array(str(self.path), path=_stem(name), mode="r").nbytes == size)
        return False

    def claimed(self) -> AbstractContextManager[None]:
        _zarr()
        check_writable(self.path, folder=True)
        return super().claimed()

    def finish(self) -> None:
        """Remove what killed processes had begun to write, which zarr gives a name of its own each time."""
        for part in self.path.rglob("*.partial"):
            part.unlink(missing_ok=True)


@dataclass(frozen=True)
class Hdf5(Folder):
    """An HDF5 file, written in the end from NPY files in a folder beside it, whole or not at all."""

    path: Path

    def save(self, name: str, array: Array, texts: Mapping[str, str]) -> int:
        return super().save(self._waiting(name), array, texts)

    def holds(self, name: str, size: int) -> bool:
        if super().holds(self._waiting(name), size):
            return True
        with suppress(OSError), _h5py().File(self.path, "r", locking=False) as file:
            return _stem(name) in file
        return False

    def claimed(self) -> AbstractContextManager[None]:
        _h5py()
        check_writable(self.path)
        return super().claimed()

    def finish(self) -> None:
        """Move the waiting arrays into the file. What is there under other names stays."""
        waiting = self.root / WAITING
        found = sorted(waiting.rglob("[!.]*.npy"))
        if not found:
            return
        with atomic_write(self.path) as temporary:
            if self.path.is_file():
                shutil.copyfile(self.path, temporary)
            # The temporary file is locked already, by us.
            with _h5py().File(temporary, "a" if self.path.is_file() else "w", locking=False) as file:
                for path in found:
                    name = _stem(path.relative_to(waiting).as_posix())
                    if name in file:
                        del file[name]
                    file.create_dataset(name, data=np.load(path), compression="gzip", compression_opts=1, shuffle=True)
        shutil.rmtree(waiting, ignore_errors=True)

    @staticmethod
    def _waiting(name: str) -> str:
        return f"{WAITING}/{_stem(name)}.npy"


WAITING = "arrays"


def _zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise FormatError("a .zarr store needs the package zarr: pip install 'ssao_gl[stores]'") from None
    return zarr


def _h5py() -> Any:
    try:
        import h5py
    except ImportError:
        raise FormatError("an HDF5 file needs the package h5py: pip install 'ssao_gl[stores]'") from None
    return h5py
