"""The table of a batch: a row for each view, as JSON lines (which the next run goes by) and as CSV (for people)."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .places import Place
from .rows import Row, read_marks, remove_marks

LINES, TABLE = "results.jsonl", "results.csv"
COLUMNS = (
    "name",
    "scene",
    "width",
    "height",
    "method",
    "seconds",
    "drawing",
    "coverage",
    "peak_mib",
    "worker",
    "warnings",
    "error",
)


@dataclass(frozen=True)
class Results:
    """How a batch ended. rows: of all its views, in its order. drawn, before: how many were drawn now, and were there before.

    failed: rows with an ``error`` of one line. seconds: of the whole run.
    """

    output: str
    rows: Sequence[Row]
    drawn: int
    before: int
    seconds: float

    @property
    def failed(self) -> list[Row]:
        """Rows of what could not be drawn."""
        return [row for row in self.rows if "error" in row]


def gathered(place: Place) -> dict[str, Row]:
    """Return name -> row of all that is known to be done, or to have failed, at a place: the table, and marks since then."""
    rows: dict[str, Row] = {}
    for line in (place.read(LINES) or b"").splitlines():
        try:
            row = json.loads(line)
            rows[row["name"]] = row
        except (ValueError, KeyError, TypeError, RecursionError):
            continue  # written by something else; what it told of is drawn again
    return rows | read_marks(place)


def write_rows(place: Place, rows: Mapping[str, Row]) -> None:
    """Write the table, then remove the marks that it has taken in. Raises FormatError."""
    place.write(LINES, "".join(json.dumps(row, sort_keys=True) + "\n" for row in rows.values()).encode())
    remove_marks(place)


def write_table(place: Place, rows: Sequence[Row]) -> None:
    """Write what people look at, as CSV. Raises FormatError."""
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    table.writeheader()
    for row in rows:
        w, h = row.get("size", ("", ""))
        table.writerow({**row, "width": w, "height": h, "warnings": " | ".join(row.get("warnings", ()))})
    place.write(TABLE, text.getvalue().encode("utf-8", "backslashreplace"))
