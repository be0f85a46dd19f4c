"""Tests of ``planner/error_model.py``."""

from __future__ import annotations

from ssao_gl.planner import error_model
from ssao_gl.planner.candidates import chosen_from


def test_the_table_knows_every_candidate() -> None:
    for layers, named in error_model.SIGNS.items():
        rows = error_model.error_weights()[str(layers)]
        assert set(rows) == {c.name for c in chosen_from([], layers)}
        for row in rows.values():
            assert set(row["weights"]) == set(named) and min(row["weights"].values()) >= 0 and sum(row["weights"].values()) > 0
            assert 0 < row["mean_rmse"] < 0.2


def test_better_presets_have_less_error() -> None:
    rows = error_model.error_weights()["2"]
    order = [rows[f"bitmask {name}"]["mean_rmse"] for name in ("draft", "low", "medium", "high", "ultra")]
    assert order == sorted(order, reverse=True)
