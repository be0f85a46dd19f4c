"""Archives, unpacked with care: what counts is the size that comes out, not the one that is announced."""

from __future__ import annotations

import bz2
import gzip
import io
import tarfile
import zipfile
from pathlib import PurePosixPath
from typing import Any, BinaryIO

from ..errors import SceneError

ARCHIVES = ("zip", "tar.gz", "tar.bz2", "bz2", "gz")
SINGLE = ("bz2", "gz")
"""Packings of one file."""
FREE, RATIO = 8 << 20, 32
"""An archive may unpack to 8 MiB, or to 32 times its size if that is more: text packs to a tenth, bombs to a thousandth."""
MAX_ENTRIES = 20_000
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Of ZIP members. zipfile unpacks the others in one go, whatever size comes out."""

Files = dict[str, bytes]


def unpack(file: BinaryIO, kind: str, size: int, name: str) -> Files:
    """Name -> content of every file in an archive of ``size`` bytes, ``name`` being its own. Raises SceneError."""
    if kind == "zip":
        return unzip(file, size)
    opener: Any = gzip.open if kind in ("tar.gz", "gz") else bz2.open
    with opener(file, "rb") as stream:
        data = stream.read(_budget(size) + 1)
    _check_budget(len(data), size)
    return {PurePosixPath(name).stem: data} if kind in SINGLE else _untar(data, size)


def unzip(file: BinaryIO, size: int) -> Files:
    """Likewise for ZIP files. Raises SceneError."""
    archive = zipfile.ZipFile(file)
    entries = [entry for entry in archive.infolist() if not entry.is_dir()]
    _check_count(len(entries))
    _check_budget(sum(entry.file_size for entry in entries), size)
    files: Files = {}
    for entry in entries:
        if entry.compress_type not in METHODS:
            raise SceneError(f"packs '{entry.filename}' in a way other than 'deflate', which is not read; pack it again")
        with archive.open(entry) as stream:
            files[entry.filename] = stream.read(entry.file_size)
    return files


def rezip(files: Files) -> BinaryIO:
    """A ZIP file in memory, not compressed: for readers that unpack it themselves, without looking."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    out.seek(0)
    return out


def _untar(data: bytes, size: int) -> Files:
    files: Files = {}
    unpacked = 0
    with tarfile.open(fileobj=io.BytesIO(data), mode="r:") as tar:
        for number, entry in enumerate(tar):
            _check_count(number)
            if entry.isfile():
                unpacked += max(entry.size, 0)  # of a sparse file, which is mostly holes
                _check_budget(unpacked, size)
                stream = tar.extractfile(entry)
                files[entry.name] = stream.read() if stream else b""
    return files


def _budget(size: int) -> int:
    return max(FREE, RATIO * size)


def _check_budget(unpacked: int, size: int) -> None:
    if unpacked > _budget(size):
        raise SceneError(f"unpacks to more than {RATIO} times its size, so it is refused; unpack it yourself if you trust it")


def _check_count(entries: int) -> None:
    if entries > MAX_ENTRIES:
        raise SceneError(f"holds more than {MAX_ENTRIES} files, so it is refused; unpack it yourself if you trust it")
