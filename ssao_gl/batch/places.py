"""Where outputs go: what any place must do, and folders. Each thing appears there whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from numpy.typing import NDArray

from ..io import images
from ..io.atomic import atomic_write, check_writable, locked_folder, make_folder

Array = NDArray[Any]


class Place(Protocol):
    """Named things, by relative paths with slashes. Instances can be sent to other processes. All raise FormatError."""

    def save(self, name: str, array: Array, texts: Mapping[str, str]) -> int:
        """Write an array by the suffix of its name, and return its size in bytes. ``texts``: of PNG files."""

    def holds(self, name: str, size: int) -> bool:
        """Whether an array of that size is there."""

    def write(self, name: str, content: bytes) -> None:
        """Write a file."""

    def read(self, name: str) -> bytes | None:
        """Return a file's content; None when there is none."""

    def names(self, folder: str) -> list[str]:
        """Return the names of the files in a folder, sorted."""

    def remove(self, name: str) -> None:
        """Remove a file, and its folder when that is empty then."""

    def claimed(self) -> AbstractContextManager[None]:
        """Within the block no other batch writes here, where that can be ensured."""

    def finish(self) -> None:
        """Do what is left when all is drawn."""


@dataclass(frozen=True)
class Folder:
    """A folder of this machine, or one that machines share."""

    root: Path

    def save(self, name: str, array: Array, texts: Mapping[str, str]) -> int:
        path = self.root / name
        make_folder(path.parent)
        images.save_image(path, array, texts=texts)
        return path.stat().st_size

    def holds(self, name: str, size: int) -> bool:
        with suppress(OSError):
            return (self.root / name).stat().st_size == size
        return False

    def write(self, name: str, content: bytes) -> None:
        path = self.root / name
        make_folder(path.parent)
        with atomic_write(path) as temporary:
            temporary.write_bytes(content)

    def read(self, name: str) -> bytes | None:
        with suppress(OSError):
            return (self.root / name).read_bytes()
        return None

    def names(self, folder: str) -> list[str]:
        with suppress(OSError):
            return sorted(path.name for path in (self.root / folder).iterdir() if path.is_file())
        return []

    def remove(self, name: str) -> None:
        path = self.root / name
        with suppress(OSError):
            path.unlink(missing_ok=True)
            path.parent.rmdir()

    def claimed(self) -> AbstractContextManager[None]:
        check_writable(self.root, folder=True)
        make_folder(self.root)
        return locked_folder(self.root)

    def finish(self) -> None:
        """Nothing is left."""
