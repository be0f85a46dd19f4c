"""Presets against the cheaper ones of their method, by rows made by hand."""

from __future__ import annotations

from typing import Any

import pytest

from ssao_gl.experiment.preset_order import preset_order


def row(view: str, variant: str, error: float | None, ms: float) -> dict[str, Any]:
    return {
        "view": view, "family": variant.split()[0], "variant": variant, "errors": {"rmse": error},
        "times": {"total": {"wall": [ms, ms, ms]}},
    }  # fmt: skip


def test_each_preset_is_compared_with_the_best_cheaper_one() -> None:
    rows = [
        row("v", "a draft", 0.10, 1), row("v", "a low", 0.08, 2), row("v", "a high", 0.09, 3),
        row("w", "a draft", 0.10, 1), row("w", "a low", 0.12, 2), row("w", "a high", 0.05, 3),
        row("v", "b low", 0.01, 1),
    ]  # fmt: skip
    found = {(one["view"], one["variant"]): (one["cheaper"], one["share"]) for one in preset_order(rows)}
    assert found == {
        ("v", "a low"): ("a draft", pytest.approx(-0.2)),
        ("v", "a high"): ("a low", pytest.approx(0.125)),
        ("w", "a low"): ("a draft", pytest.approx(0.2)),
        ("w", "a high"): ("a draft", pytest.approx(-0.5)),
    }


def test_what_noise_decides_is_not_cheaper() -> None:
    """Faster in one view and slower in another: none of the two is the cheaper one."""
    rows = [row(view, name, 0.1, ms) for view, times in (("v", (1, 2)), ("w", (2, 1))) for name, ms in zip("ab", times, strict=True)]  # fmt: skip
    for one in rows:
        one["family"] = "m"
    assert preset_order(rows) == []
    rows[2]["times"]["total"]["wall"] = [0.5, 0.5, 0.5]
    assert [(one["variant"], one["cheaper"], one["share"]) for one in preset_order(rows)] == [("b", "a", 0.0)] * 2


def test_views_that_a_preset_refuses_are_passed_over() -> None:
    refused = {"view": "v", "family": "a", "variant": "a low", "refused": "no"}
    assert preset_order([row("v", "a draft", 0.1, 1), refused, row("v", "a high", None, 3)]) == []
