"""The tables of a comparison: means over views, and what changed in each view."""

from __future__ import annotations

from collections.abc import Sequence

from .columns import Cell, Column, Table
from .compare import ALIKE, ERROR, ERRORS, TIME, Change, ViewChange


def comparison_tables(found: Sequence[Change], views: Sequence[ViewChange]) -> list[Table]:
    """Return the tables that have rows: of means, and of the views in which an error changed."""
    return [table for table in (_means(found), _by_view(views)) if table.rows]


def _means(found: Sequence[Change]) -> Table:
    rows: list[list[Cell]] = [
        [
            one.label, one.what, one.views, one.better, one.worse, one.before, one.after, one.share,
            f"{one.low:+.2%} .. {one.high:+.2%}", one.verdict,
        ]
        for one in found
        if one.what in (ERROR, TIME) or one.better or one.worse
    ]  # fmt: skip
    columns = (
        Column("variant"), Column("what"), Column("views", "d"), Column("better", "d"), Column("worse", "d"), Column("before", ".4g"),
        Column("after", ".4g"), Column("change", "+.2%"), Column("95 % of resamplings"), Column("verdict"),
    )  # fmt: skip
    note = (
        "Paired over views, the largest growth of RMSE first. Zones and blotches without the truth's own noise; time as a multiple"
        f" of the baseline; zones and blotches that changed in no view are not listed. better, worse: views that changed by more than {ALIKE[ERROR]:.1%}, {ALIKE[TIME]:.0%} of the time."
    )
    return Table("Change between the reports", note, columns, rows)


def _by_view(views: Sequence[ViewChange]) -> Table:
    changed = [one for one in views if any(one.verdict(what) != "same" for what in ERRORS)]
    rows: list[list[Cell]] = [
        [
            one.view, one.label, one.before[ERROR], one.after[ERROR], *(one.share(what) for what in (*ERRORS, TIME)), one.verdict(),
        ]
        for one in changed
    ]  # fmt: skip
    columns = (
        Column("view"), Column("variant"), Column("before", ".4f"), Column("after", ".4f"),
        *(Column(what, "+.1%") for what in (*ERRORS, TIME)), Column("verdict"),
    )  # fmt: skip
    better, worse = (sum(one.verdict() == verdict for one in views) for verdict in ("better", "worse"))
    note = (
        f"RMSE is better in {better} of {len(views)} pairs of view and variant, worse in {worse}; the other {len(views) - len(changed)}"
        " that are not listed changed in no error. The worst first."
    )
    return Table("Change in each view", note, columns, rows)
