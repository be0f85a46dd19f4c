"""Tests of ``experiment/timing.py``."""

from __future__ import annotations

import pytest

from ssao_gl.experiment import points, timing


def row(variant: str, view: str, rmse: float, ms: float) -> dict[str, object]:
    clocks = {"wall": [ms, ms, ms], "cpu": [ms, ms, ms]}
    times = {"passes": {variant: clocks}, **dict.fromkeys((*timing.GROUPS, "total"), clocks)}
    return {"variant": variant, "view": view, "family": variant, "preset": "default", "realtime": True, "prepared": {"ms": 0.0, "bytes": 0}, "errors": {"rmse": rmse, "bias": 0.0},
            "times": times, "baseline": {"wall": [5, 5, 5], "cpu": [5, 5, 5]}}  # fmt: skip


def test_points_are_means_and_a_variant_that_sits_out_is_no_rival() -> None:
    rows = [
        row("a", "v", 0.1, 10),
        row("a", "w", 0.2, 20),
        row("b", "v", 0.3, 30),
        row("b", "w", 0.3, 30),
        row("c", "v", 0.01, 1),
    ]
    a, b, c = points.points(rows, {"v", "w"}, track="shipped")
    assert a["errors"]["rmse"] == pytest.approx(0.15) and a["wall"]["total"] == 15 and a["ratio"] == pytest.approx(3)
    assert (a["front"], b["front"], c["front"]) == (True, False, False) and c["views"] == 1
