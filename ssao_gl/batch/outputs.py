"""From the word behind ``-o`` to a place."""

from __future__ import annotations

from pathlib import Path

from ..errors import FormatError
from .objects import Objects
from .places import Folder, Place
from .stores import Hdf5, Zarr

STORES = (".zarr", ".h5", ".hdf5")
BESIDE = ".batch"
"""Suffix of the folder beside a store: results, cameras, notes of what is done."""


def place_of(output: Path | str) -> Place:
    """Return where an output goes: a URL, a .zarr, .h5 or .hdf5 store, or else a folder. Raises FormatError."""
    text = str(output)
    if "://" in text:
        return Objects(text.rstrip("/"))
    path = Path(text)
    suffix = path.suffix.lower()
    if suffix in STORES:
        beside = path.with_name(path.name + BESIDE)
        return Zarr(beside, path) if suffix == ".zarr" else Hdf5(beside, path)
    if suffix and not path.is_dir():
        raise FormatError(f"-o {path}: suffix '{suffix}'; a batch goes to a folder, or to one store: {', '.join(STORES)}")
    return Folder(path)
