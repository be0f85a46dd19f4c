"""Tests of ``report/compare.py``."""

from __future__ import annotations

from typing import Any

import numpy as np
from pytest import approx

from ssao_gl.report import compare
from ssao_gl.report.compare_tables import comparison_tables
from ssao_gl.report.markdown import grid


def test_bootstrap_sees_a_change_and_no_change() -> None:
    random = np.random.default_rng(3)
    before = random.uniform(0.05, 0.1, 18)
    low, high = compare.interval(before, before * random.uniform(1.03, 1.07, 18))
    assert 0.03 < low < 0.05 < high < 0.07
    low, high = compare.interval(before, before * random.uniform(0.9, 1.1, 18))
    assert low < 0 < high
    assert compare.interval(before, before) == (0, 0)
    assert compare.interval(before, before * 1.1) == compare.interval(before, before * 1.1)  # the seed is fixed


def report(**scale: float) -> dict[str, object]:
    times = {"total": {"wall": [1.0, 2.0, 3.0]}}
    rows = [
        {"variant": name, "view": f"v{i}", "errors": {"rmse": 0.1 * factor * (1 + 0.01 * i)}, "times": times, "baseline": {"wall": [1, 1, 1]}}
        for name, factor in scale.items()
        for i in range(4)
    ]  # fmt: skip
    return {"rows": {"estimate": [*rows, {"variant": "a", "view": "w", "refused": "no"}]}}


def hand_made(**errors: dict[str, float]) -> dict[str, Any]:
    """One variant, its errors in each view."""
    times = {"total": {"wall": [1.0, 2.0, 3.0]}}
    rows = [
        {"variant": "m", "view": view, "errors": one, "times": times, "baseline": {"wall": [1, 1, 1]}} for view, one in errors.items()
    ]  # fmt: skip
    return {"rows": {"estimate": rows}, "settings": {"code": "x", "truth": {"spp": 4}}}


OLD = hand_made(
    v={"rmse": 0.10, "rmse_edge_net": 0.20, "rmse_flat_net": 0.05, "blotches_net": 0.01},
    w={"rmse": 0.10, "rmse_edge_net": 0.20, "rmse_flat_net": 0.05, "blotches_net": 0.01},
    x={"rmse": 0.10, "rmse_edge_net": 0.20, "rmse_flat_net": 0.05, "blotches_net": 0.0},
    y={"rmse": 0.10},
)
NEW = hand_made(
    v={"rmse": 0.05, "rmse_edge_net": 0.08, "rmse_flat_net": 0.05, "blotches_net": 0.01},
    w={"rmse": 0.12, "rmse_edge_net": 0.26, "rmse_flat_net": 0.05, "blotches_net": 0.01},
    x={"rmse": 0.1002, "rmse_edge_net": 0.20, "rmse_flat_net": 0.05, "blotches_net": 0.02},
    y={"rmse": 0.1002},
    z={"rmse": 0.1},
)


def test_each_view_says_what_got_better_or_worse() -> None:
    views = compare.view_changes(OLD, NEW)
    assert [(one.view, one.verdict()) for one in views] == [("w", "worse"), ("x", "same"), ("y", "same"), ("v", "better")]
    shares = {one.view: {what: one.share(what) for what in (*compare.ERRORS, compare.TIME)} for one in views}
    assert shares["w"] == {
        "RMSE": approx(0.2), "edge": approx(0.3), "crease": None, "flat": 0, "blotches": 0, "time": 0,
    }  # fmt: skip
    assert shares["v"]["edge"] == approx(-0.6) and shares["y"]["edge"] is None
    assert shares["x"]["blotches"] == 1  # there were none
    assert [one.view for one in compare.view_regressions(views, 0.1)] == ["w"]
    assert not compare.view_regressions(views, 0.25) and not compare.view_regressions(views, None)
    assert views[0].describe() == "m in w: RMSE 0.1 -> 0.12 (+20.0 %)"


def test_means_count_views() -> None:
    found = {one.what: one for one in compare.changes(compare.view_changes(OLD, NEW))}
    assert list(found) == ["RMSE", "edge", "flat", "blotches", "time"]
    assert [(one.views, one.better, one.worse) for one in found.values()] == [
        (4, 1, 1),
        (3, 1, 1),
        (3, 0, 0),
        (3, 0, 1),
        (4, 0, 0),
    ]
    assert found["RMSE"].share == approx(0.3704 / 0.4 - 1) and found["RMSE"].verdict == "same"


def test_variants_that_grew_most_come_first() -> None:
    found = compare.changes(compare.view_changes(report(a=1, b=1, c=1), report(a=0.9, b=1.2, c=1.1)))
    assert [one.label for one in found if one.what == compare.ERROR] == ["b", "c", "a"]


def test_tables_leave_out_what_did_not_change() -> None:
    views = compare.view_changes(OLD, NEW)
    means, by_view = comparison_tables(compare.changes(views), views)
    assert [row[0] for row in by_view.rows] == ["w", "x", "v"]
    assert "better in 1 of 4" in by_view.note and "worse in 1; the other 1 that" in by_view.note
    for table in (means, by_view):
        assert all(len(row) == len(table.columns) for row in table.rows)
    assert grid(by_view).splitlines()[2] == (
        "| w | m | 0.1000 | 0.1200 | +20.0% | +30.0% | – | +0.0% | +0.0% | +0.0% | worse |"
    )
    assert [row[1] for row in means.rows] == ["RMSE", "edge", "blotches", "time"]
    same = compare.view_changes(OLD, OLD)
    assert [table.title for table in comparison_tables(compare.changes(same), same)] == ["Change between the reports"]


def test_other_truths_are_named() -> None:
    other = {**NEW, "settings": {"code": "y", "truth": {"spp": 8}, "rounds": 1}}
    assert compare.unlike(OLD, other) == ["truth", "rounds"] and compare.unlike(OLD, NEW) == []


def test_comparison_names_regressions_only_beyond_the_limit() -> None:
    found = compare.changes(compare.view_changes(report(a=1, b=1, c=1, gone=1), report(a=1.05, b=0.9, c=1.01)))
    verdicts = {change.label: change.verdict for change in found if change.what == compare.ERROR}
    assert verdicts == {"a": "worse", "b": "better", "c": "worse"}
    assert [change.label for change in compare.regressions(found, 0.02, None)] == ["a"]
    assert not compare.regressions(found, 0.06, None)
