"""Tables of zones, views and presets, from results made by hand."""

from __future__ import annotations

from typing import Any

import pytest

from ssao_gl.experiment.preset_order import preset_order
from ssao_gl.metrics.zones import ZONES
from ssao_gl.report.columns import Table
from ssao_gl.report.zone_tables import WHERE, WHERE_KEYS, worst_first, zone_tables

RMSE = {("v", "m low"): 0.05, ("v", "m high"): 0.0520, ("w", "m low"): 0.10, ("w", "m high"): 0.08, ("x", "m low"): 0.02, ("x", "m high"): 0.0205}  # fmt: skip


@pytest.fixture
def found() -> dict[str, Any]:
    rows = [
        {
            "view": view, "variant": label, "family": "m", "errors": dict.fromkeys(WHERE_KEYS, 0.01) | {"rmse": error},
            "times": {"total": {"wall": [ms, ms, ms]}},
        }
        for (view, label), error in RMSE.items()
        for ms in [2.0 if "high" in label else 1.0]
    ]  # fmt: skip
    views = [{"view": view, "zones": {"edge": 0.25, "crease": 0.15, "flat": None if view == "x" else 0.6}} for view in "vwx"]
    shipped = [{"label": label, "errors": {"rmse": 0.05, "share_edge": 0.75}} for label in ("m low", "m high")]
    at = {"size": "8x6", "views": list("vwx"), "shipped": shipped, "preset_order": preset_order(rows)}
    return {"sizes": [at], "rows": {"view": views, "estimate": [*rows, {"view": "x", "variant": "n", "refused": "no"}]}}


def named(found: dict[str, Any]) -> dict[str, Table]:
    return {table.title: table for table in zone_tables(found)}


def test_a_column_for_each_error(found: dict[str, Any]) -> None:
    assert len(WHERE) == len(WHERE_KEYS) and [column.title for column in WHERE if column.title in ZONES] == list(ZONES)
    table = named(found)["Where the error is, 8x6"]
    assert table.rows[0][:3] == ["m low", 0.05, None] and table.rows[0][1 + WHERE_KEYS.index("share_edge")] == 0.75
    assert (
        "edge 25%, crease 15%, flat 60%" in table.note and "sqrt(max(RMSE² - mean of squared standard errors, 0))" in table.note
    )


def test_the_worst_views_come_first(found: dict[str, Any]) -> None:
    assert worst_first(found) == ["w", "v", "x"]
    tables = named(found)
    assert [row[0] for row in tables["RMSE by view"].rows] == ["w", "v", "x"]
    assert [row[:3] for row in tables["Where the error is, by view"].rows][:3] == [
        ["w", "m low", 0.10], ["w", "m high", 0.08], ["v", "m low", 0.05],
    ]  # fmt: skip


def test_presets_out_of_order_are_listed_by_view(found: dict[str, Any]) -> None:
    tables = named(found)
    (row,) = tables["Presets in order, 8x6"].rows
    assert row == ["m high", 3, 2, 1, pytest.approx(0.04), "m low", "v"]
    (row,) = tables["Presets out of order, 8x6"].rows  # 2.5 % worse in x is in order
    assert row == ["v", "m high", 0.0520, "m low", 0.05, pytest.approx(0.04)]
