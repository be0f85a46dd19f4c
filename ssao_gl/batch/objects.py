"""Outputs in an object store, by fsspec."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from ..errors import FormatError, one_line
from ..io import images
from .places import Array


@dataclass(frozen=True)
class Objects:
    """A store that fsspec knows by URL, as s3://bucket/folder or memory://folder; objects there appear whole."""

    url: str

    @property
    def _files(self) -> tuple[Any, str]:
        try:
            import fsspec
        except ImportError:
            raise FormatError(f"{self.url}: needs the package fsspec: pip install 'ssao_gl[cluster]'") from None
        try:
            return fsspec.core.url_to_fs(self.url)  # type: ignore[no-any-return]
        except (ValueError, ImportError) as error:
            raise FormatError(f"{self.url}: {one_line(error)}") from None

    def save(self, name: str, array: Array, texts: Mapping[str, str]) -> int:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, PurePosixPath(name).name)
            images.save_image(path, array, texts=texts)
            content = path.read_bytes()
        self.write(name, content)
        return len(content)

    def holds(self, name: str, size: int) -> bool:
        files, root = self._files
        with suppress(OSError):
            return bool(files.info(f"{root}/{name}")["size"] == size)
        return False

    def write(self, name: str, content: bytes) -> None:
        files, root = self._files
        try:
            files.makedirs(str(PurePosixPath(root, name).parent), exist_ok=True)
            files.pipe_file(f"{root}/{name}", content)
        except OSError as error:
            raise FormatError(f"cannot write {self.url}/{name}: {error.strerror or one_line(error)}") from None

    def read(self, name: str) -> bytes | None:
        files, root = self._files
        with suppress(OSError):
            return bytes(files.cat_file(f"{root}/{name}"))
        return None

    def names(self, folder: str) -> list[str]:
        files, root = self._files
        files.invalidate_cache()
        with suppress(OSError):
            found = files.ls(f"{root}/{folder}", detail=True)
            return sorted(PurePosixPath(one["name"]).name for one in found if one["type"] == "file")
        return []

    def remove(self, name: str) -> None:
        files, root = self._files
        with suppress(OSError):
            files.rm_file(f"{root}/{name}")
        with suppress(OSError):
            files.rmdir(str(PurePosixPath(root, name).parent))

    def claimed(self) -> AbstractContextManager[None]:
        return nullcontext()

    def finish(self) -> None:
        """Nothing is left."""
