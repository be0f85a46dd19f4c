"""Tests of ``planner/calibration.py``."""

from __future__ import annotations

import logging
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ssao_gl.planner import calibration
from ssao_gl.planner.candidates import FAMILIES
from ssao_gl.planner.cost_model import CostRate


def driver(**changes: str) -> Any:
    return SimpleNamespace(**{"provider": "egl-es", "renderer": "a renderer", "version": "OpenGL ES 3.2", **changes})


def renderer(**changes: str) -> Any:
    return SimpleNamespace(ctx=driver(**changes))


def test_the_key_goes_by_driver_and_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = calibration.key(driver())
    assert calibration.key(driver()) == before
    for change in ("provider", "renderer", "version"):
        assert calibration.key(driver(**{change: "another"})) != before
    monkeypatch.setattr(calibration, "code_fingerprint", lambda: "another")
    assert calibration.key(driver()) != before


@pytest.fixture
def probes(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Counts probes, which draw nothing here."""
    drawn: list[str] = []

    def probe(of: Any) -> dict[str, dict[str, CostRate]]:
        drawn.append(of.ctx.renderer)
        return {family.name: {"bitmask": CostRate(1, 2, 3, 4)} for family in FAMILIES}

    monkeypatch.setattr(calibration, "probe", probe)
    return drawn


def test_a_driver_is_probed_once(tmp_path: Path, probes: list[str]) -> None:
    found = [calibration.calibrated(renderer(), tmp_path / "cache") for _ in range(2)]
    assert probes == ["a renderer"] and found[0] == found[1]
    calibration.calibrated(renderer(renderer="another"), tmp_path / "cache")
    assert probes == ["a renderer", "another"]


@pytest.mark.parametrize(
    "content", ["", "{", "[" * 100_000, "[]", "{}", '{"bitmask draft": 3}', "-1", "NaN", "Infinity", "1e999"]
)
def test_a_damaged_calibration_is_made_anew(
    tmp_path: Path, probes: list[str], caplog: pytest.LogCaptureFixture, content: str
) -> None:
    found = calibration.calibrated(renderer(), tmp_path)
    (path,) = tmp_path.glob("planner-*.json")
    rates = content in ("-1", "NaN", "Infinity", "1e999")
    path.write_text(path.read_text().replace("1.0", content).replace("1,", f"{content},") if rates else content)
    with caplog.at_level(logging.WARNING):
        assert calibration.calibrated(renderer(), tmp_path) == found
    assert "is damaged" in caplog.text and len(probes) == 2
    assert calibration.calibrated(renderer(), tmp_path) == found and len(probes) == 2, "and is whole again"


def test_a_cache_that_cannot_be_written_costs_a_warning(
    tmp_path: Path, probes: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    with caplog.at_level(logging.WARNING):
        assert calibration.calibrated(renderer(), tmp_path / "file" / "cache")
    assert "going on without" in caplog.text and len(probes) == 1
