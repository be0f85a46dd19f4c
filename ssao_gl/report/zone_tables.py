"""The tables that tell where the error is: by zone, by view, and by preset."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..experiment.preset_order import CLEARLY, TOLERANCE
from ..experiment.statistics import mean
from ..experiment.steps import ESTIMATE
from ..metrics.blotches import BAND
from ..metrics.zones import CREASE_BAND, EDGE_BAND, STEP, TURN, ZONES
from .columns import Cell, Column, Table, by_variant, text

WHERE = (
    Column("RMSE", ".4f", "root mean square error against rays, as measured"),
    Column("net", ".4f", "RMSE without the truth's own noise"),
    Column("p99", ".3f", "error that 99 % of the pixels stay below"),
    *(
        column
        for zone in ZONES
        for column in (
            Column(zone, ".4f", f"RMSE in the zone ‘{zone}’, without the truth's own noise"),
            Column(f"{zone} bias", "+.4f", f"mean error in the zone ‘{zone}’; above 0 is too bright"),
            Column(f"{zone} share", ".0%", f"of the squared error, in the zone ‘{zone}’"),
        )
    ),
    Column("blotches", ".4f", f"RMSE on flat ground with wavelengths of {BAND[0]:g} to {BAND[1]:g} pixels, without the noise"),
    Column("FLIP", ".3f", "of the dimmed picture"),
)
WHERE_KEYS = (
    "rmse", "rmse_net", "p99", *(key.format(zone) for zone in ZONES for key in ("rmse_{}_net", "bias_{}", "share_{}")),
    "blotches_net", "flip",
)  # fmt: skip
"""Errors that :data:`WHERE` shows, in its order."""


def zone_tables(found: Mapping[str, Any]) -> list[Table]:
    """Tables of zones, of views, and of the order of presets; some may have no rows."""
    made = [table for at in found["sizes"] for table in (_zones(at, found), _order(at), _out_of_order(at))]
    return [*made, _views(found), _zones_by_view(found)]


def worst_first(found: Mapping[str, Any]) -> list[str]:
    """Names of the views, that of the largest RMSE (mean over all variants) first."""
    errors: dict[str, list[float | None]] = {view["view"]: [] for view in found["rows"]["view"]}
    for row in found["rows"][ESTIMATE]:
        errors.setdefault(row["view"], []).append(row.get("errors", {}).get("rmse"))
    return sorted(errors, key=lambda view: -(mean(errors[view]) or 0.0))


def _zones(at: Mapping[str, Any], found: Mapping[str, Any]) -> Table:
    views = [view["zones"] for view in found["rows"]["view"] if view["view"] in at["views"]]
    pixels = ", ".join(f"{zone} {text(mean([view[zone] for view in views]), '.0%')}" for zone in ZONES)
    rows = [[p["label"], *(p["errors"].get(key) for key in WHERE_KEYS)] for p in at["shipped"]]
    note = (
        f"Zones are of the truth's depth and normals. edge: within {EDGE_BAND} pixels of a depth edge, a step of more than"
        f" {STEP:g} radii that no tangent plane explains; crease: within {CREASE_BAND} pixels of normals that turn by more than"
        f" {math.degrees(TURN):.0f} degrees; flat: the rest. Of the pixels: {pixels}. Truth's own noise is subtracted in each"
        " view, sqrt(max(RMSE² - mean of squared standard errors, 0)), but in the first column; results.csv has all figures as"
        f" measured, too. share: of the squared error. blotches: the error on flat ground by wavelengths of {BAND[0]:g} to"
        f" {BAND[1]:g} pixels. Means over {len(at['views'])} views."
    )
    return Table(f"Where the error is, {at['size']}", note, (Column("variant"), *WHERE), rows)


def _order(at: Mapping[str, Any]) -> Table:
    rows: list[list[Cell]] = []
    for label, some in by_variant(at["preset_order"]).items():
        worst = max(some, key=lambda one: one["share"])
        off = sum(one["share"] > TOLERANCE for one in some)
        rows.append([label, len(some), len(some) - off, off, worst["share"], worst["cheaper"], worst["view"]])
    columns = (
        Column("variant"), Column("views", "d"), Column("in order", "d"), Column("out of order", "d"),
        Column("largest change", "+.1%", "of RMSE, to the best cheaper preset; above 0 is worse"), Column("against"), Column("in view"),
    )  # fmt: skip
    note = (
        f"Each preset against the best of its method's cheaper ones: those that are faster in at least {CLEARLY:.0%} of the views. Out of"
        f" order: its RMSE is higher by more than {TOLERANCE:.0%}."
    )
    return Table(f"Presets in order, {at['size']}", note, columns, rows)


def _out_of_order(at: Mapping[str, Any]) -> Table:
    off = sorted((one for one in at["preset_order"] if one["share"] > TOLERANCE), key=lambda one: -one["share"])
    keys = ("view", "variant", "rmse", "cheaper", "cheaper_rmse", "share")
    columns = (
        Column("view"), Column("variant"), Column("RMSE", ".4f"), Column("cheaper"), Column("its RMSE", ".4f"),
        Column("change", "+.1%", "of RMSE, to the cheaper preset"),
    )  # fmt: skip
    note = "Views in which a cheaper preset of the same method is better, the worst first."
    return Table(f"Presets out of order, {at['size']}", note, columns, [[one[key] for key in keys] for one in off])


def _views(found: Mapping[str, Any]) -> Table:
    grouped = by_variant(found["rows"][ESTIMATE])
    cells = {(label, row["view"]): row["errors"]["rmse"] for label, some in grouped.items() for row in some if "errors" in row}
    rows = [[view, *(cells.get((label, view)) for label in grouped)] for view in worst_first(found)]
    columns = (Column("view"), *(Column(label, ".4f") for label in grouped))
    return Table("RMSE by view", "As shipped, the worst views first (by the mean over all variants).", columns, rows)


def _zones_by_view(found: Mapping[str, Any]) -> Table:
    by_view: dict[str, list[list[Cell]]] = {view: [] for view in worst_first(found)}
    for row in found["rows"][ESTIMATE]:
        if "errors" in row:
            by_view[row["view"]].append([row["view"], row["variant"], *(row["errors"].get(key) for key in WHERE_KEYS)])
    note = "As above, for each view, the worst views first."
    rows = [row for some in by_view.values() for row in some]
    return Table("Where the error is, by view", note, (Column("view"), Column("variant"), *WHERE), rows)
