"""What is measured so far, on disk: JSON lines, each with its checksum, each there before the next is begun.

A killed run loses the row it was at. The next one with the same arguments finds the others, and goes on.
"""

from __future__ import annotations

import json
import logging
import os
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from ..errors import FormatError
from .atomic import atomic_write, make_folder, why_unreadable
from .json_values import to_json
from .locks import lock

NAME = "journal.jsonl"
JournalRow = dict[str, Any]
Key = tuple[str, str, str, str]
log = logging.getLogger("ssao_gl")


class Journal:
    """Rows, each with the key (kind, view, variant, at); where a key comes twice the later row counts."""

    def __init__(self, folder: Path, header: Mapping[str, Any], contents: Mapping[str, str]) -> None:
        """``header``: all that the rows depend on beside their keys. ``contents``: view -> hash of what is seen there.

        Rows of a view that has other content now are passed over. A journal under another header, or a damaged one, is moved aside with a warning; of a damaged one the good rows
        are taken over. Raises FormatError when the folder cannot be written, or another process is at it.
        """
        make_folder(folder)
        self._path = folder / NAME
        self._rows: dict[Key, JournalRow] = {}
        self._contents = dict(contents)
        wanted = to_json(dict(header))
        self._file = self._open()
        found, damaged = _read(self._path)
        if found and found[0] != wanted:
            aside = _aside(self._path, "other")
            log.warning(
                "%s belongs to a report with other %s; it is kept as %s", self._path, _differing(found[0], wanted), aside.name
            )
            found = []
        elif damaged:
            aside = _aside(self._path, "damaged")
            log.warning("%s has %d damaged lines; it is kept as %s, good rows go on", self._path, damaged, aside.name)
        for row in found[1:]:
            if row.get("content") == self._contents.get(row.get("view", "")):
                self._rows[_key(row)] = row
        self._rewrite([wanted, *found[1:]])

    def _open(self) -> IO[bytes]:
        if (reason := why_unreadable(self._path, empty=True)) and self._path.exists():  # a pipe may never open
            raise FormatError(f"cannot write {self._path}: {reason}")
        try:
            file = self._path.open("ab")
        except OSError as error:
            raise FormatError(f"cannot write {self._path}: {error.strerror or error}") from None
        try:
            lock(file.fileno(), self._path.parent)
        except FormatError:
            file.close()
            raise
        return file

    def _rewrite(self, rows: list[JournalRow]) -> None:
        """All of it at once, without what was cut or damaged."""
        with atomic_write(self._path) as temporary:
            temporary.write_bytes(b"".join(map(_line, rows)))
        self._file.close()
        self._file = self._open()

    def find(self, kind: str, view: str = "", variant: str = "", at: str = "") -> JournalRow | None:
        """Return the row of a key, or None."""
        return self._rows.get((kind, view, variant, at))

    def rows(self, kind: str) -> Iterator[JournalRow]:
        """All rows of a kind, in the order in which they were made."""
        return (row for key, row in self._rows.items() if key[0] == kind)

    def add(self, kind: str, view: str = "", variant: str = "", at: str = "", **values: Any) -> JournalRow:
        """Put a row on the disk. Raises FormatError when it is full."""
        key = {"kind": kind, "view": view, "variant": variant, "at": at, "content": self._contents.get(view)}
        row: JournalRow = to_json({**key, **values})
        try:
            self._file.write(_line(row))
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise FormatError(f"cannot write {self._path}: {error.strerror or error}") from None
        self._rows[_key(row)] = row
        return row

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _key(row: JournalRow) -> Key:
    return str(row.get("kind")), str(row.get("view")), str(row.get("variant")), str(row.get("at"))


def _line(row: JournalRow) -> bytes:
    text = json.dumps(row, sort_keys=True, allow_nan=False)
    return json.dumps({"crc": zlib.crc32(text.encode()), "row": row}, sort_keys=True, allow_nan=False).encode() + b"\n"


def _read(path: Path) -> tuple[list[JournalRow], int]:
    """(good rows, number of damaged lines). A last line without an end is what a killed process left, and no damage."""
    rows, damaged = [], 0
    with path.open("rb") as file:
        for line in file:
            row = _parsed(line)
            if row is not None:
                rows.append(row)
            elif line.endswith(b"\n"):
                damaged += 1
    if damaged and (not rows or "kind" in rows[0]):  # the header is lost, and with it what the rows mean
        rows = []
    return rows, damaged


def _parsed(line: bytes) -> JournalRow | None:
    try:
        content = json.loads(line)
        row: JournalRow = content["row"]
        good = zlib.crc32(json.dumps(row, sort_keys=True, allow_nan=False).encode()) == content["crc"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return row if good and isinstance(row, dict) else None


def _differing(old: JournalRow, new: JournalRow) -> str:
    return ", ".join(key for key in {**old, **new} if old.get(key) != new.get(key)) or "content"


def _aside(path: Path, why: str) -> Path:
    """Make a copy of the file beside it, under a name that is free."""
    number = 1
    while (place := path.with_name(f"{path.stem}.{why}-{number}{path.suffix}")).exists():
        number += 1
    with atomic_write(place) as temporary:
        temporary.write_bytes(path.read_bytes())
    return place
