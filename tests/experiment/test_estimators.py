"""Whatever yields visibility for a view is measured, told and drawn without an edit anywhere else."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.experiment.environment import machine
from ssao_gl.experiment.estimators import Preparation, Prepared, Rays, ScreenSpace
from ssao_gl.experiment.residual import ResidualRays
from ssao_gl.experiment.results import results
from ssao_gl.experiment.run import Run
from ssao_gl.experiment.sweep import Sweep
from ssao_gl.experiment.view_setup import ViewSetup
from ssao_gl.experiment.views import views
from ssao_gl.gl.timer import PassTime
from ssao_gl.io.journal import Journal
from ssao_gl.truth import Tracing

pytest.importorskip("embreex")
pytest.importorskip("matplotlib")
pytest.importorskip("flip_evaluator")


@dataclass(frozen=True)
class Grey:
    """One visibility everywhere; what is no image of it, it refuses."""

    value: float
    family = "grey"
    most_rounds = 1
    realtime = False
    pictured = True
    drawn = []  # noqa: RUF012 - counts, for the test

    @property
    def preset(self) -> str:
        return f"{self.value:g}"

    @property
    def label(self) -> str:
        return f"grey {self.value:g}"

    def table(self) -> Mapping[str, Any]:
        return {"method": "grey", "value": self.value}

    def prepare(self, setup: ViewSetup) -> Prepared:
        if self.value > 1:
            raise SettingsError("grey: at most 1")
        return Painted(setup.size, self.value)


@dataclass(frozen=True)
class Painted:
    size: tuple[int, int]
    value: float
    preparation = Preparation(ms=12.5, bytes=3 << 20)

    def draw(self) -> np.ndarray:
        return np.full(self.size[::-1], self.value, np.float32)

    def time(self) -> Sequence[PassTime]:
        Grey.drawn.append(self.value)
        return [PassTime("paint", 2.0, "wall", 3.0, "occlusion")]


def measured(folder: Path, renderer: ao.Renderer, *others: Any) -> dict[str, Any]:
    seen = views([], [], [(48, 27)])
    methods = [ScreenSpace("alchemy", "default", ao.Settings(method=ao.Alchemy()))]
    sweep = Sweep(views=seen, methods=methods, others=others, tracing=Tracing(spp=4), rounds=3)
    facts = machine(renderer.ctx)
    with Journal(folder, sweep.header(facts, "code"), sweep.contents) as journal:
        Run(sweep, renderer, journal, folder, None, lambda *_: None).measure()
        return results(sweep, journal, facts, "2026", "made by a test")


def test_an_estimator_of_somebody_elses_is_measured_like_ours(tmp_path: Path, any_renderer: ao.Renderer) -> None:
    Grey.drawn.clear()
    found = measured(tmp_path, any_renderer, Grey(0.5), Grey(2.0), Rays(1))
    points = {point["label"]: point for point in found["sizes"][0]["shipped"]}
    assert list(points) == ["alchemy", "grey 0.5", "rays 1"]
    grey = points["grey 0.5"]
    assert grey["prepared"] == {"ms": 12.5, "bytes": 3 << 20} and grey["wall"]["total"] == 2.0 and grey["cpu"]["total"] == 3.0
    assert Grey.drawn == [0.5, 0.5], "a round to warm up, and the one that is enough for it"
    assert points["rays 1"]["prepared"]["ms"] > 0 and points["alchemy"]["prepared"] == {"ms": 0.0, "bytes": 0}

    from ssao_gl.report.write import write

    write(found, tmp_path)
    text = (tmp_path / "report.md").read_text()
    assert "| grey 0.5 |" in text and "grey: at most 1" in text, "what it refuses is told"
    assert "grey 0.5" in (tmp_path / "report.html").read_text() and "grey,0.5" in (tmp_path / "results.csv").read_text()
    rows = [json.loads(line)["row"] for line in (tmp_path / "journal.jsonl").read_text().splitlines()[1:]]
    assert {row["kind"] for row in rows} == {"view", "estimate"}


def test_a_few_rays_upon_a_method(tmp_path: Path, any_renderer: ao.Renderer) -> None:
    """Their tree is prepared, their rays and their filter are part of each frame."""
    base = ScreenSpace("bitmask", "medium", ao.Settings())
    found = measured(tmp_path, any_renderer, ResidualRays(base, 0.25))
    point = next(point for point in found["sizes"][0]["shipped"] if point["label"] == "bitmask medium + rays 1/4")
    assert point["family"] == "bitmask + rays" and not point["realtime"] and point["prepared"]["ms"] > 0
    row = next(row for row in found["rows"]["estimate"] if row["variant"] == point["label"])
    assert {"rays", "gather residuals", "residual filter"} <= set(row["times"]["passes"]) and row["settings"]["rays"] == 0.25


def test_names_are_escaped_in_pages(tmp_path: Path, any_renderer: ao.Renderer) -> None:
    @dataclass(frozen=True)
    class Hostile(Grey):
        @property
        def label(self) -> str:
            return "<script>alert(1)</script> | x"

    from ssao_gl.report.write import write

    write(measured(tmp_path, any_renderer, Hostile(0.5)), tmp_path)
    assert "<script>alert" not in (tmp_path / "report.html").read_text()
    markdown = (tmp_path / "report.md").read_text()
    assert "<script>alert" not in markdown and "\\| x" in markdown
