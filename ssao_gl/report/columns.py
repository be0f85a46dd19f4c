"""What tables are made of: cells, columns with their meaning, and how each is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..metrics.zones import ZONES

Cell = str | float | None


@dataclass(frozen=True, slots=True)
class Column:
    """A heading, how its numbers are written (a format spec) and what it means."""

    title: str
    spec: str = ""
    help: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Cells are texts or numbers, None where there is nothing."""

    title: str
    note: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    marked: Sequence[bool] = ()
    """Whether each row stands out: what is on the Pareto front, say. Empty: none does."""


ERRORS = (
    Column("RMSE", ".4f", "root mean square error against rays, foreground"),
    Column("bias", "+.4f", "mean error; above 0 is too bright"),
    Column("p95", ".3f", "error that 95 % of the pixels stay below"),
    Column("p99", ".3f", "error that 99 % of the pixels stay below"),
    Column("max", ".3f", "largest error"),
    Column("PSNR", ".1f", "dB"),
    Column("SSIM", ".3f", "structural similarity"),
    Column("FLIP", ".3f", "of the dimmed picture"),
    Column("noise", ".4f", "pixel to pixel, on flat ground"),
    Column("border", ".4f", "RMSE within 32 pixels of the image's border"),
)
KEYS = ("rmse", "bias", "p95", "p99", "max", "psnr", "ssim", "flip", "noise", "rmse_border")
"""Errors that :data:`ERRORS` shows, in its order; those of zones are in :mod:`.zone_tables`."""

ALL_KEYS = (
    *KEYS, "rmse_net", "blotches", "blotches_net",
    *(key.format(zone) for zone in ZONES for key in ("rmse_{}", "rmse_{}_net", "bias_{}", "share_{}")),
)  # fmt: skip
"""Every error that is measured; ``_net``: without the truth's own noise."""

COSTS = (
    Column("ms", ".1f", "wall or GPU time of all passes after the G-buffer"),
    Column("CPU ms", ".1f", "of all threads"),
    Column("× baseline", ".2f", "multiple of the lecture's 4-tap pass alone, by wall or GPU time"),
    Column("× by CPU", ".2f", "the same by CPU time"),
)

PREPARED = (
    Column("prepared ms", ".1f", "once for a view, before its first frame, and in no other column: a tree of the scene, say"),
    Column("prepared MiB", ".1f", "what that keeps in memory"),
)


def text(cell: Cell, spec: str = "") -> str:
    """Return a cell as it is shown; nothing is a dash."""
    if cell is None:
        return "–"
    return cell if isinstance(cell, str) else format(cell, spec or ".4g")


def by_variant(rows: Iterable[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Rows by the label of their estimator."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        found.setdefault(row["variant"], []).append(row)
    return found
