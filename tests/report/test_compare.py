"""Tests of ``report/compare.py``."""

from __future__ import annotations

import numpy as np

from ssao_gl.report import compare


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


def test_comparison_names_regressions_only_beyond_the_limit() -> None:
    found = compare.changes(report(a=1, b=1, c=1, gone=1), report(a=1.05, b=0.9, c=1.01))
    verdicts = {change.label: change.verdict for change in found if change.what == compare.ERROR}
    assert verdicts == {"a": "worse", "b": "better", "c": "worse"}
    assert [change.label for change in compare.regressions(found, 0.02, None)] == ["a"]
    assert not compare.regressions(found, 0.06, None)
