"""Output files appear whole or not at all: written beside their place under a name with a dot, then moved.

That name is always the same for an output, and locked while it is written. So a second run that writes the same output at
the same time is told so; and what a killed process left, whose locks the system has dropped, is taken over and gone after
the next run. (Where files cannot be locked, as on Windows, each process has a name of its own, and neither is done.)
A link is followed; devices and pipes are written to as they are (see :mod:`.streams`).
"""

from __future__ import annotations

import os
import struct
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import FormatError
from .locks import lock
from .streams import STDOUT, check_stream, is_stream, stream_write


def why_unreadable(path: Path, *, empty: bool = False) -> str | None:
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


def is_folder(path: Path) -> bool:
    """Whether ``path`` is a folder; also a name that no file can have is none, where Path raises OSError."""
    try:
        return path.is_dir()
    except OSError:
        return False


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to, moved to ``path`` when the block ends well and removed when it does not.

    Raises FormatError, in one line, when the place cannot be written, or another run is at it; BrokenPipeError when nobody
    reads standard output any more.
    """
    path = Path(path)
    try:
        with stream_write(path) if is_stream(path) else replaced(path, followed(path)) as temporary:
            yield temporary
    except OSError as error:
        if path == STDOUT and isinstance(error, BrokenPipeError):
            raise
        raise _refused(path, error) from None
    except (ValueError, struct.error) as error:  # encoders say so that a picture is too large for their format
        raise FormatError(f"cannot write {path}: {error}") from error


def followed(path: Path) -> Path:
    """Return where a link leads, be it there or not; ``path`` itself when it is none. Raises OSError for links in a circle."""
    if not path.is_symlink():
        return path
    with suppress(FileNotFoundError):
        path.stat()
    return Path(os.path.realpath(path))


@contextmanager
def replaced(path: Path, target: Path) -> Iterator[Path]:
    """Give a temporary path, moved to ``target`` when the block ends well; messages call that ``path``.

    The command line lets no signal in while this runs, for what is made and not yet noted would stay. Raises OSError,
    FormatError.
    """
    temporary, handle = _claim(path, target)
    try:
        yield temporary
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    finally:
        if handle is not None:
            os.close(handle)


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Within the block no other run claims ``folder``, which exists: files of two runs would mix. Raises FormatError."""
    if sys.platform == "win32":
        yield
        return
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise FormatError(f"cannot write {folder}: {error.strerror or error}") from None
    try:
        lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _refused(path: Path, error: OSError) -> FormatError:
    """numpy says only how much it could not write."""
    return FormatError(f"cannot write {path}: {error.strerror or f'{error}; is the disk full?'}")


def _temporary(path: Path, mark: str = "") -> Path:
    """Where ``path`` is written. A long name is cut, and told from others by a checksum."""
    stem = os.fsencode(path.stem)
    name = path.stem if len(stem) <= 100 else f"{path.stem[:20]}-{zlib.crc32(stem):08x}"
    return path.with_name(f".{name}{mark}.part{path.suffix}")


def _claim(path: Path, target: Path) -> tuple[Path, int | None]:
    """Return an empty file to write ``target`` to, and the handle by which it is locked until that is closed.

    Raises OSError, FormatError.
    """
    temporary = _temporary(target)
    while sys.platform != "win32":
        handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            if not lock(handle, path):
                os.close(handle)
                temporary.unlink(missing_ok=True)
                break
            held = os.fstat(handle)
            if _is(held, temporary) and held.st_uid == os.geteuid() and held.st_nlink == 1:
                os.ftruncate(handle, 0)
                return temporary, handle
            if _is(held, temporary):
                temporary.unlink()  # somebody else's, who could read or change what we write
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # another run has just moved or removed it
    temporary = _temporary(target, f".{os.getpid()}")
    temporary.write_bytes(b"")
    return temporary, None


def _is(held: os.stat_result, place: Path) -> bool:
    """Whether ``place`` is still the file that is held."""
    try:
        return os.path.samestat(held, place.lstat())
    except FileNotFoundError:
        return False


def check_writable(path: Path, *, folder: bool = False) -> None:
    """Raise FormatError, before any work is done, when a file (or a folder and files in it) cannot be made at ``path``."""
    if not folder and is_stream(path):
        check_stream(path)
        return
    try:
        target = followed(path)
        target.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:  # ValueError: a null byte
        raise FormatError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from None
    place = target if folder else target.parent
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
        raise FormatError(f"cannot write {path}: {error.strerror or error} (in the folder {place})") from None


def make_folder(path: Path) -> None:
    """Make a folder for outputs. Raises FormatError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(f"cannot make the folder {path}: {error.strerror or error}") from None
