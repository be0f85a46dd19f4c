"""Tests of ``stress/verdicts.py``."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import ssao_gl as ao
from ssao_gl.methods.base import Deviation
from ssao_gl.stress import report
from ssao_gl.stress.case import Case
from ssao_gl.stress.catalogue import cases
from ssao_gl.stress.outcomes import NotApplicable
from ssao_gl.stress.runner import Broken
from ssao_gl.stress.shapes import lens
from ssao_gl.stress.shot import Shot
from ssao_gl.stress.specimen import specimens
from ssao_gl.stress.verdicts import ABSENT, DECLARED, FAIL, PASS, CaseResult, judged, runs


def verdict(measure: Callable[[Any], float], exceptions: dict[str, Deviation] | None = None, **more: Any) -> CaseResult:
    """The verdict on a case that needs no OpenGL."""
    declared = exceptions or {}
    subject = SimpleNamespace(
        name="m", preset="default", exceptions=declared, refuses=lambda c: c in declared and math.isinf(declared[c].bound)
    )
    lab = SimpleNamespace(subject=subject, renderer=SimpleNamespace(ctx=SimpleNamespace(provider="p")))
    return judged(Case("c", "g", "promise", "unit", 0.1, measure, **more), lab)[0]  # type: ignore[arg-type]


def failing(error: Exception) -> Callable[[Any], float]:
    def measure(lab: Any) -> float:
        raise error

    return measure


def test_verdicts() -> None:
    declared = {"plane": Deviation(0.5, "so it is defined"), "orthographic": Deviation(math.inf, "perspective only")}
    assert verdict(lambda lab: 0.1).verdict == PASS
    assert verdict(lambda lab: 0.2).verdict == FAIL
    assert verdict(lambda lab: math.nan).verdict == FAIL
    row = verdict(lambda lab: 0.2, declared, contract="plane")
    assert (row.verdict, row.measured, row.declared, row.reason) == (DECLARED, 0.2, 0.5, "so it is defined")
    assert verdict(lambda lab: 0.6, declared, contract="plane").verdict == FAIL
    assert verdict(lambda lab: 0.05, declared, contract="plane").verdict == PASS
    refusal = failing(ao.SettingsError("m: perspective only"))
    assert verdict(refusal, declared, asks=("orthographic",)).verdict == DECLARED
    assert verdict(refusal, declared).verdict == FAIL
    assert verdict(refusal, {"orthographic": Deviation(1, "")}, asks=("orthographic",)).verdict == FAIL
    assert verdict(failing(NotApplicable("nothing there"))).verdict == ABSENT
    assert verdict(failing(Broken("not finite", Shot(lens())))).reason == "not finite"
    assert "unforeseen ZeroDivisionError" in verdict(failing(ZeroDivisionError("x"))).reason


def test_cases_without_a_method_run_once() -> None:
    every = runs(cases().values(), specimens())
    once = [case.name for case, _ in every if case.once]
    assert len(once) == len(set(once)) > 3


def rows() -> report.StressResults:
    results = report.StressResults()
    common: dict[str, Any] = {"group": "g", "preset": "default", "provider": "p", "unit": "u", "bound": 0.1}
    results.add(CaseResult(case="a", method="x", verdict=PASS, measured=0.01, **common))
    results.add(CaseResult(case="a", method="y", verdict=DECLARED, measured=0.3, declared=0.5, reason="as <defined>", **common))
    results.add(
        CaseResult(case="b", method="y", verdict=FAIL, measured=math.nan, reason="bad", command="ssao-gl stress", **common)
    )
    results.add(CaseResult(case="random-7", method="x", verdict=PASS, measured=0, **common))
    results.add(CaseResult(case="random-8", method="x", verdict=FAIL, reason="black", **common))
    return results


def test_results_are_counted_and_laid_out() -> None:
    results = rows()
    assert results.counts() == {PASS: 2, DECLARED: 1, ABSENT: 0, FAIL: 2}
    assert [row.case for row in results.failed] == ["b", "random-8"]
    columns, lines = report.matrix(results.named)
    assert columns == ["case", "x", "y"]
    assert lines == [["a", "0.01", "0.3 <= 0.5 declared"], ["b", "", "FAIL nan"]]


def test_results_as_files(tmp_path: Path) -> None:
    for name in ("r.json", "r.html"):
        report.save_stress_report(tmp_path / name, rows(), {"command": "ssao-gl stress", "p": "a <driver>"})
    data = json.loads((tmp_path / "r.json").read_text())
    assert data["counts"][FAIL] == 2 and len(data["rows"]) == 4 and data["rows"][2]["measured"] is None
    page = (tmp_path / "r.html").read_text()
    assert "as &lt;defined&gt;" in page and "a &lt;driver&gt;" in page and "<script" not in page
