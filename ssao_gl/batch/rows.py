"""What is known of a job when it was drawn, or could not be: a row of the results, as JSON values.

While a batch runs each row lies in a file of its own (a *mark*), written after the outputs by whoever drew them; a batch begins
and ends by gathering the marks into the table of results.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from typing import Any

from .jobs import ViewJob
from .places import Place

Row = dict[str, Any]
MARKS = ".marks"
"""Folder of the marks; a name with a dot is no scene's."""
LONGEST = 100


def failure(job: ViewJob, error: str) -> Row:
    """Return the row of a job that could not be drawn, with one line that says why."""
    return {"name": job.name, "scene": str(job.scene), "size": list(job.size), "error": error}


def put_mark(place: Place, row: Row) -> None:
    """Note that a job is done. Raises FormatError."""
    content = json.dumps(row, sort_keys=True).encode()
    place.write(_path(row["name"]), b"%08x %s" % (zlib.crc32(content), content))


def mark_of(place: Place, job: ViewJob) -> Row | None:
    """Return the row of a job that is done already, by whomever; None when it is not, or its outputs are gone."""
    row = _parsed(place.read(_path(job.name)))
    return row if row is not None and is_done(place, job, row) else None


def is_done(place: Place, job: ViewJob, row: Row) -> bool:
    """Whether a row tells of this very job, and its outputs are there."""
    outputs = row.get("outputs")
    if row.get("identity") != job.identity or not isinstance(outputs, dict):
        return False
    files = [file for every in job.files.values() for file in every]
    return set(outputs) == set(files) and all(place.holds(file, size) for file, size in outputs.items())


def read_marks(place: Place) -> dict[str, Row]:
    """Return the rows of all marks by name, in the order of names; damaged ones are passed over."""
    rows = (_parsed(place.read(f"{MARKS}/{name}")) for name in place.names(MARKS))
    return {row["name"]: row for row in rows if row is not None}


def remove_marks(place: Place) -> None:
    """Remove all marks; the table of results has them."""
    for name in place.names(MARKS):
        place.remove(f"{MARKS}/{name}")


def _path(name: str) -> str:
    plain = name.replace("/", "+")
    if len(plain) > LONGEST:  # than file systems take
        plain = hashlib.sha256(name.encode()).hexdigest()
    return f"{MARKS}/{plain}.json"


def _parsed(content: bytes | None) -> Row | None:
    try:
        check, _, text = (content or b"").partition(b" ")
        row = json.loads(text)
        return row if zlib.crc32(text) == int(check, 16) and isinstance(row["name"], str) else None
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
