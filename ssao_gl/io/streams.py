"""Outputs that are no regular files: standard output, devices and pipes. They are written to, and never replaced."""

from __future__ import annotations

import errno
import os
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ..errors import FormatError

STDOUT = Path("-")
WAIT = 10.0
"""Seconds that a pipe may take to find its reader."""
CHUNK = 1 << 20


def is_stream(path: Path) -> bool:
    """Return whether ``path`` is standard output (``-``), a device of characters or a pipe, also by a link.

    Raises FormatError for what must not be written to: block devices, which are disks, and sockets.
    """
    if path == STDOUT:
        return True
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    for refused, what in ((stat.S_ISBLK, "a block device"), (stat.S_ISSOCK, "a socket")):
        if refused(mode):
            raise FormatError(f"cannot write {path}: it is {what}; expected a file")
    return stat.S_ISCHR(mode) or stat.S_ISFIFO(mode)


def output_suffix(path: Path) -> str:
    """Return the suffix by which ``path`` is written, in small letters; PNG goes to streams that have none."""
    return path.suffix.lower() or (".png" if is_stream(path) else "")


def check_stream(path: Path) -> None:
    """Raise FormatError, before any work is done, when a stream cannot be written."""
    if path == STDOUT:
        if sys.stdout.isatty():
            raise FormatError("cannot write -: standard output is a terminal; send it to a file or a pipe")
    elif not os.access(path, os.W_OK):
        raise FormatError(f"cannot write {path}: {os.strerror(errno.EACCES)}")


@contextmanager
def stream_write(path: Path) -> Iterator[Path]:
    """Give a temporary file, and send it to the stream when the block ends well: encoders move about in what they write.

    Raises OSError, FormatError.
    """
    try:
        folder = tempfile.TemporaryDirectory(prefix="ssao_gl-")
    except OSError as error:
        raise FormatError(
            f"cannot make a temporary folder: {error.strerror or error}; set TMPDIR to one that has room"
        ) from None
    with folder as name:
        temporary = Path(name) / f"output{output_suffix(path)}"
        temporary.write_bytes(b"")
        yield temporary
        send(temporary, path)


def send(source: Path, path: Path) -> None:
    """Send the bytes of a file to a stream. Raises OSError, FormatError."""
    with source.open("rb") as file:
        if path != STDOUT:
            with os.fdopen(_opened(path), "wb", buffering=0) as out:
                _copy(file, out)
            return
        sys.stdout.flush()
        buffer = sys.stdout.buffer
        _copy(file, getattr(buffer, "raw", buffer))  # what fails must not stay in a buffer, to fail again at the end


def _copy(file: BinaryIO, out: BinaryIO) -> None:
    while chunk := file.read(CHUNK):
        rest = memoryview(chunk)
        while rest:
            rest = rest[out.write(rest) :]


def _opened(path: Path) -> int:
    """Open a device, or a pipe as soon as somebody reads from it."""
    until = time.monotonic() + WAIT
    flags = os.O_WRONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
    while True:
        try:
            handle = os.open(path, flags)
        except OSError as error:
            if error.errno != errno.ENXIO:
                raise
            if time.monotonic() > until:
                raise FormatError(f"cannot write {path}: nothing reads from this pipe") from None
            time.sleep(0.05)
            continue
        os.set_blocking(handle, True)
        return handle


@contextmanager
def silenced() -> Iterator[None]:
    """Send what C code of this process prints within the block to nowhere: the error that it raises says as much."""
    kept: list[tuple[int, int]] = []
    try:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):  # it may be closed, or none
                stream.flush()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for handle in (1, 2):
            with suppress(OSError):  # it may be closed
                kept.append((handle, os.dup(handle)))
                os.dup2(nowhere, handle)
        os.close(nowhere)
        yield
    finally:
        for handle, copy in kept:
            os.dup2(copy, handle)
            os.close(copy)
