"""The planner on a driver: probe frames, plans of views, and pictures by them."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.planner import apply_planned, calibration, plan_arrays, render_planned
from ssao_gl.planner.candidates import CANDIDATES, FAMILIES, chosen_from
from ssao_gl.planner.choice import Choice, choose
from ssao_gl.planner.plan import ROUNDS, SMALLER
from ssao_gl.render.renderer import Renderer
from ssao_gl.scene.model import Scene
from ssao_gl.truth import Tracing, trace

from ..command_line import refused, run
from ..shapes import camera, plane

SIZE = (160, 96)
ALL = ao.Target(budget_ms=1e9)


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Calibrations of this module go to a folder of its own."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder / "ssao_gl"


@pytest.fixture(scope="module")
def choice(any_renderer: ao.Renderer, embedded: Scene) -> Choice:
    """Of the embedded scene, without any bound that matters."""
    return ao.plan(any_renderer, embedded, None, SIZE, ALL)


def test_probe_frames_tell_rates_once(any_renderer: ao.Renderer, choice: Choice, cache: Path, monkeypatch: Any) -> None:
    """Of every pass but those that draw the scene, for every family; the next run draws none."""

    def fail(renderer: ao.Renderer) -> None:
        raise AssertionError("probed again")

    monkeypatch.setattr(calibration, "probe", fail)
    rates = calibration.calibrated(any_renderer, cache)
    for family in FAMILIES:
        settings = ao.Settings(method=family.candidates[0].made(1.0))
        drawn = {step.task.name for step in plan_render(settings, SIZE).steps}
        assert set(rates[family.name]) == drawn - {"gbuffer", "layer behind"}
        rate = rates[family.name][family.method]
        assert rate.shaded + rate.tapped > 0


def test_every_candidate_is_considered(choice: Choice) -> None:
    assert {p.name for p in choice.considered} == set(CANDIDATES)
    assert [p.ms for p in choice.considered] == sorted(p.ms for p in choice.considered)
    assert all(p.ms > 0 and 0 < p.error < 0.3 for p in choice.considered)
    assert choice.prediction.error == min(p.error for p in choice.considered)
    assert choice.settings.method == CANDIDATES[choice.prediction.name][1].made(choice.settings.method.radius)


def test_more_taps_cost_more(choice: Choice) -> None:
    """Within a family predictions rise, whatever noise the clock has: no rate is negative."""
    ms = {p.name: p.ms for p in choice.considered}
    for family in FAMILIES:
        found = [ms[c.name] for c in family.candidates]
        assert found == sorted(found), found


def test_few_frames_are_drawn(any_renderer: ao.Renderer, embedded: Scene, choice: Choice, monkeypatch: Any) -> None:
    """Three small ones, and the timed ones of full size."""
    drawn: list[tuple[tuple[int, int], int]] = []
    render = Renderer.render

    def counted(self: Renderer, scene: Scene, camera: Any, size: Any, *rest: Any, **named: Any) -> Any:
        drawn.append((size, named.get("timed", 0)))
        return render(self, scene, camera, size, *rest, **named)

    monkeypatch.setattr(Renderer, "render", counted)
    ao.plan(any_renderer, embedded, None, SIZE, ALL)
    small = (SIZE[0] // SMALLER, SIZE[1] // SMALLER)
    assert drawn[:3] == [(small, 0)] * 3 and set(drawn[3:]) == {(SIZE, ROUNDS)} and len(drawn) <= 5


def test_the_picture_is_that_of_the_chosen_settings(any_renderer: ao.Renderer, embedded: Scene, choice: Choice) -> None:
    picture = render_planned(any_renderer, embedded, None, SIZE, ao.Target(max_error=1.0))
    planned = picture.report["planned"]
    cheapest = min(choice.considered, key=lambda p: p.ms)
    assert planned["of"] == len(CANDIDATES) and planned["chosen"] in CANDIDATES
    assert planned["took_ms"] > 0 and planned["predicted_ms"] > 0 and planned["max_error"] == 1.0
    assert planned["predicted_error"] == pytest.approx(
        next(p.error for p in choice.considered if p.name == planned["chosen"]), rel=1e-6
    ), "errors are predicted from pictures, which are the same each time"
    assert cheapest.name.startswith("bitmask") or cheapest.name.startswith("alchemy")
    radius = choice.settings.method.radius
    settings = dataclasses.replace(ao.Settings(), method=CANDIDATES[planned["chosen"]][1].made(radius))
    again = any_renderer.render(embedded, None, SIZE, settings)
    assert np.array_equal(picture.image, again.image) and np.array_equal(picture.visibility, again.visibility)


def test_radius_light_and_rules_are_kept(any_renderer: ao.Renderer, embedded: Scene) -> None:
    given = ao.Settings(shading=ao.Shading(ambient=0.5), keep=("open",)).with_radius(0.123)
    found = ao.plan(any_renderer, embedded, None, SIZE, ALL, given).settings
    assert found.method.radius == 0.123 and found.shading == given.shading and found.keep == given.keep


def test_a_named_method_is_kept(any_renderer: ao.Renderer, embedded: Scene) -> None:
    found = ao.plan(any_renderer, embedded, None, SIZE, ALL, ao.Settings(method=ao.Alchemy()))
    assert {p.name for p in found.considered} == {c.name for c in chosen_from(["alchemy"], 2)}
    assert found.settings.method.name == "alchemy"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (ao.Settings(method=ao.Alchemy(samples=5)), "leave out samples=5"),
        (ao.Settings(method=ao.Lecture()), "nothing is known of 'lecture'"),
        (ao.Settings(blur=None), "leave blur out"),
        (ao.Settings(blur=ao.Joint(radius=3)), "leave blur out"),
        (ao.Settings(normals="shading"), "leave normals out"),
    ],
)
def test_what_it_would_overrule_is_refused(
    any_renderer: ao.Renderer, embedded: Scene, settings: ao.Settings, message: str
) -> None:
    with pytest.raises(ao.SettingsError, match=re.escape(message)):
        ao.plan(any_renderer, embedded, None, SIZE, ALL, settings)


def test_out_of_reach(any_renderer: ao.Renderer, embedded: Scene) -> None:
    with pytest.raises(
        ao.SettingsError, match=r"^at most 1e-06 ms is out of reach here; the nearest is \w+ .* ms, RMSE 0\.\d+$"
    ):
        render_planned(any_renderer, embedded, None, SIZE, ao.Target(budget_ms=1e-6))
    with pytest.raises(ao.SettingsError, match="an RMSE of at most 1e-06 is out of reach here; the nearest is"):
        render_planned(any_renderer, embedded, None, SIZE, ao.Target(max_error=1e-6))


def test_arrays(any_renderer: ao.Renderer, embedded: Scene) -> None:
    seen = embedded.default_camera(SIZE)
    picture = any_renderer.render(embedded, seen, SIZE, aovs=("depth", "normal", "image"))
    for more in ({}, {"normals": picture.normal}, {"color": picture.image}):
        found = apply_planned(any_renderer, picture.depth, seen, ALL, **more)
        planned = found.report["planned"]
        assert planned["of"] == len(chosen_from([], 1)) and CANDIDATES[planned["chosen"]][1].layers == 1
        assert found.visibility.shape == SIZE[::-1] and planned["took_ms"] > 0
    with pytest.raises(ao.FormatError, match="depth is float64 of shape"):
        plan_arrays(any_renderer, np.ones(3), seen, ALL)


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (2, 64)])
def test_small_and_empty_views(any_renderer: ao.Renderer, embedded: Scene, size: tuple[int, int]) -> None:
    assert ao.plan(any_renderer, embedded, None, size, ALL).prediction.ms > 0
    away = camera(pose=np.diag([-1.0, 1.0, -1.0, 1.0]))
    nothing = ao.plan(any_renderer, plane(), away, size, ao.Target(max_error=1e-9))
    assert nothing.prediction.error == 0 and nothing.prediction.ms == nothing.considered[0].ms
    assert np.all(render_planned(any_renderer, plane(), away, size, ao.Target(max_error=1e-9)).visibility == 1)
    with pytest.warns(ao.InputWarning, match="no usable texel"):
        assert plan_arrays(any_renderer, np.zeros(size[::-1], np.float32), away, ALL).prediction.error == 0


def test_errors_are_as_predicted(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """Within half to twice: a scene that had no part in the table. The choice among presets follows their true order."""
    size, seen = (640, 360), embedded.default_camera((640, 360))
    choice = ao.plan(any_renderer, embedded, seen, size, ALL)
    truth = trace(embedded, seen, size, Tracing(spp=64, radius=choice.settings.method.radius))
    found = {}
    for name in ("draft", "low", "medium", "high", "ultra"):
        settings = ao.Settings(method=CANDIDATES[f"bitmask {name}"][1].made(choice.settings.method.radius))
        off = any_renderer.render(embedded, seen, size, settings, aovs=("visibility",)).visibility - truth.visibility
        found[name] = float(np.sqrt((off[truth.covered] ** 2).mean() - truth.noise**2))
        expected = next(p.error for p in choice.considered if p.name == f"bitmask {name}")
        assert 0.5 < found[name] / expected < 2, (name, found[name], expected)
    assert found["ultra"] < found["medium"] < found["draft"]
    assert choose(choice.considered, ao.Target(max_error=0.9 * found["draft"])).error < found["draft"]


# command line


@pytest.mark.gl
def test_render_says_what_was_planned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("render", "--size", "96x64", "--budget-ms", "1e6", "-o", tmp_path / "a.png", "--json", tmp_path / "a.json")
    code, out, _ = run(*arguments, capsys=capsys)
    assert code == 0 and (tmp_path / "a.png").is_file()
    line = out.splitlines()[1]
    assert re.fullmatch(r"planned: \w+ .*, of \d+; predicted [\d.e+]+ ms and RMSE 0\.\d+, took [\d.e+]+ ms \(.*\)", line), line
    planned = json.loads((tmp_path / "a.json").read_text())["planned"]
    assert planned["chosen"] in line and planned["budget_ms"] == 1e6


@pytest.mark.gl
def test_turntables_are_planned_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run("render", "--size", "64x48", "--max-error", "0.5", "--turntable", 2, "-o", tmp_path / "t", capsys=capsys)
    assert code == 0 and out.startswith("planned: ") and "t/: 2 frames" in out and len(list((tmp_path / "t").iterdir())) == 2


@pytest.mark.gl
def test_apply_says_what_was_planned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "depth.npy", np.full((32, 48), 2, np.float32))
    arguments = ("--depth", tmp_path / "depth.npy", "--yfov-deg", 40, "--max-error", 0.5, "-o", tmp_path / "v.npy")
    code, out, _ = run("apply", *arguments, capsys=capsys)
    assert code == 0 and out.splitlines()[1].startswith("planned: ") and (tmp_path / "v.npy").is_file()


@pytest.mark.gl
def test_explain_lists_what_was_considered(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run("explain", "--size", "96x64", "--budget-ms", "1e6", capsys=capsys)
    assert code == 0 and "chosen for at most 1e+06 ms" in out and all(name in out for name in CANDIDATES)
    code, out, _ = run("explain", "--size", "96x64", "--budget-ms", "1e6", "--json", capsys=capsys)
    planned = json.loads(out)["planned"]
    assert {one["name"] for one in planned["considered"]} == set(CANDIDATES) and planned["chosen"] in CANDIDATES


@pytest.mark.gl
def test_out_of_reach_is_one_line_and_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for target in (("--budget-ms", "1e-6"), ("--max-error", "1e-6")):
        line = refused(capsys, "render", "--size", "64x48", *target, "-o", tmp_path / "a.png")
        assert "out of reach here; the nearest is" in line
    assert "drawn in tiles" in refused(
        capsys, "render", "--size", "96x64", "--tile", 64, "--budget-ms", 9, "-o", tmp_path / "a.png"
    )
    assert list(tmp_path.iterdir()) == []


def test_arguments_of_0_1_warn_and_do_as_they_did(any_renderer: ao.Renderer, embedded: Scene) -> None:
    with pytest.warns(DeprecationWarning, match=r"go in 0\.3; use ssao_gl\.plan"):
        picture = any_renderer.render(embedded, None, SIZE, budget_ms=1e9)
    assert picture.report["planned"]["budget_ms"] == 1e9
    with pytest.warns(DeprecationWarning):
        again = any_renderer.apply(
            picture.depth if "depth" in picture.arrays else np.ones(SIZE[::-1], np.float32),
            ao.Camera.perspective(0.9, 0.1, 40),
            budget_ms=1e9,
        )
    assert again.report["planned"]["of"] > 1
