"""The user's folder for what can be made again: written if that can be, read if it is whole, kept below a size."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

import platformdirs

from ..errors import FormatError, one_line
from .atomic import atomic_write, make_folder

MOST_BYTES = 2 << 30
"""The folder is kept below this; what was not used for longest goes first."""

Content = TypeVar("Content")
log = logging.getLogger("ssao_gl")


def default_folder() -> Path:
    """Return where this platform keeps what can be made again: ``$XDG_CACHE_HOME/ssao_gl`` and its kin."""
    return platformdirs.user_cache_path("ssao_gl", appauthor=False)


def write_cached(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file of a cache. One that cannot be written costs the next run its time, and this one a warning."""
    try:
        make_folder(path.parent)
        with atomic_write(path) as temporary:
            write(temporary)
    except FormatError as error:
        log.warning("%s; going on without", error)


def read_cached(path: Path, read: Callable[[Path], Content]) -> Content | None:
    """Return what :func:`write_cached` wrote; None when there is none, or, with a warning, when it is damaged."""
    if not path.is_file():
        return None
    try:
        return read(path)
    except Exception as error:  # files break in many ways
        log.warning("%s is damaged (%s); making it anew", path, one_line(error, 120) or type(error).__name__)
        return None


def prune(folder: Path, kind: str, most: int = MOST_BYTES) -> None:
    """Remove the files ``kind-*`` that were not used for longest until the rest take at most ``most`` bytes."""
    files = []
    # With a dot: what a process that was killed had begun to write.
    for path in [*folder.glob(f"{kind}-*"), *folder.glob(f".{kind}-*")]:
        with suppress(OSError):
            files.append((path.stat().st_mtime, path.stat().st_size, path))
    over = sum(size for _, size, _ in files) - most
    for _, size, path in sorted(files):
        if over <= 0:
            return
        with suppress(OSError):
            path.unlink()
            over -= size
