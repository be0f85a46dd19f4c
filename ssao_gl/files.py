"""Output files appear whole or not at all: written beside their place under a temporary name, then moved."""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import FormatError


def unreadable(path: Path, *, empty: bool = False) -> str | None:
    """Why ``path`` cannot be read as a file, in words, or None. Devices and pipes are refused: they may never end.

    ``empty``: whether a file without content will do.
    """
    try:
        if not path.exists():
            return "no such file"
        if path.is_dir():
            return "is a folder"
        if not path.is_file():
            return "is not a regular file"
        with path.open("rb") as file:
            return None if file.read(1) or empty else "the file is empty"
    except OSError as error:
        return error.strerror or str(error)
    except ValueError as error:  # a null byte in the name
        return str(error)


@contextmanager
def written(path: Path) -> Iterator[Path]:
    """A temporary path to write to, moved to ``path`` when the block ends well and removed when it does not.

    Raises FormatError, in one line, when the place cannot be written.
    """
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem[:40]}.", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise FormatError(f"cannot write {path}: {error.strerror or error}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())  # noqa: PTH101 - mkstemp makes files for the owner alone
        temporary.replace(path)
    except OSError as error:
        raise FormatError(f"cannot write {path}: {error.strerror or error}") from None
    except (ValueError, struct.error) as error:  # encoders say so that a picture is too large for their format
        raise FormatError(f"cannot write {path}: {error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: Path, *, folder: bool = False) -> None:
    """Raise FormatError, before any work is done, when a file (or a folder and files in it) cannot be made at ``path``."""
    place = path if folder else path.parent
    while folder and not place.exists() and place != place.parent:
        place = place.parent
    if not folder and path.is_dir():
        raise FormatError(f"cannot write {path}: it is a folder")
    if not place.is_dir():
        raise FormatError(
            f"cannot write {path}: {f'{place} is not a folder' if place.exists() else f'there is no folder {place}'}"
        )
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise FormatError(f"cannot write {path}: {error.strerror or error}") from None


def make_folder(path: Path) -> None:
    """Make a folder for outputs. Raises FormatError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(f"cannot make the folder {path}: {error.strerror or error}") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
