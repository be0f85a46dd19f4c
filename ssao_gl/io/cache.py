"""The folder of what can be made again, and its size."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

MOST_BYTES = 2 << 30
"""The folder is kept below this; what was not used for longest goes first."""


def default_folder() -> Path:
    """Where this platform keeps what can be made again: ``$XDG_CACHE_HOME/ssao_gl`` and its kin."""
    given = os.environ.get("XDG_CACHE_HOME")
    if given:
        return Path(given) / "ssao_gl"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ssao_gl" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "ssao_gl"
    return Path.home() / ".cache" / "ssao_gl"


def prune(folder: Path, most: int) -> None:
    """Remove the files that were not used for longest until the rest take at most ``most`` bytes."""
    files = []
    # With a dot: what a process that was killed had begun to write.
    for path in [*folder.glob("truth-*.npz"), *folder.glob(".truth-*.npz")]:
        with suppress(OSError):
            files.append((path.stat().st_mtime, path.stat().st_size, path))
    over = sum(size for _, size, _ in files) - most
    for _, size, path in sorted(files):
        if over <= 0:
            return
        with suppress(OSError):
            path.unlink()
            over -= size
