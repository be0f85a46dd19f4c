"""The planner's pure parts: which prediction is chosen, what costs and errors are predicted from, what invalidates the cache."""

from __future__ import annotations

import dataclasses
import logging
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ssao_gl as ao
from ssao_gl.graph.regions import DrawRegion
from ssao_gl.pipeline.build import plan_render
from ssao_gl.pipeline.presets import preset
from ssao_gl.planner import calibration, error_model
from ssao_gl.planner.candidates import CANDIDATES, FAMILIES, PROBES, chosen_from, differing
from ssao_gl.planner.choice import Prediction, Target, choose
from ssao_gl.planner.cost_model import DRAWN, CostRate, Measured, PassWork, PlannedFrame, fitted
from ssao_gl.planner.features import ViewFeatures, off_plane, view_features
from ssao_gl.planner.plan import COARSE, DEEP, FINE
from ssao_gl.scene.projection import ViewConstants

from ..command_line import refused

# choice

positive = st.floats(1e-3, 1e3)
some = st.lists(st.tuples(positive, positive), min_size=1, max_size=12).map(
    lambda pairs: [Prediction(f"p{i}", ms, error) for i, (ms, error) in enumerate(pairs)]
)


@given(some, positive, positive)
def test_more_time_is_never_worse(predictions: list[Prediction], one: float, other: float) -> None:
    low, high = sorted((one, other))
    try:
        few = choose(predictions, Target(budget_ms=low))
    except ao.SettingsError:
        assert all(p.ms > low for p in predictions)
        return
    many = choose(predictions, Target(budget_ms=high))
    assert few.ms <= low and many.ms <= high and many.error <= few.error
    assert few.error == min(p.error for p in predictions if p.ms <= low)


@given(some, positive, positive)
def test_more_error_is_never_dearer(predictions: list[Prediction], one: float, other: float) -> None:
    low, high = sorted((one, other))
    try:
        strict = choose(predictions, Target(max_error=low))
    except ao.SettingsError:
        assert all(p.error > low for p in predictions)
        return
    loose = choose(predictions, Target(max_error=high))
    assert strict.error <= low and loose.error <= high and loose.ms <= strict.ms
    assert strict.ms == min(p.ms for p in predictions if p.error <= low)


@given(some, positive, positive)
def test_both_targets_hold(predictions: list[Prediction], budget: float, bound: float) -> None:
    fit = [p for p in predictions if p.ms <= budget and p.error <= bound]
    try:
        chosen = choose(predictions, Target(budget_ms=budget, max_error=bound))
    except ao.SettingsError:
        assert not fit
        return
    assert chosen in fit and chosen.ms == min(p.ms for p in fit)


@pytest.mark.parametrize(
    ("target", "nearest"),
    [({"budget_ms": 5}, "quick: 10 ms, RMSE 0.100"), ({"max_error": 0.01}, "good: 40 ms, RMSE 0.020"),
     ({"budget_ms": 12, "max_error": 0.05}, "quick: 10 ms, RMSE 0.100")],
)  # fmt: skip
def test_out_of_reach_says_what_is_nearest(target: dict[str, float], nearest: str) -> None:
    predictions = [Prediction("good", 40, 0.02), Prediction("quick", 10, 0.1)]
    with pytest.raises(ao.SettingsError) as caught:
        choose(predictions, Target(**target))
    assert str(caught.value).endswith(f"is out of reach here; the nearest is {nearest}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("bad", [0, -1.0, float("nan"), float("inf"), True, "5"])
@pytest.mark.parametrize("name", ["budget_ms", "max_error"])
def test_targets_are_numbers_above_zero(name: str, bad: Any) -> None:
    with pytest.raises(ao.SettingsError, match=f"{name}=.*: must be a finite number above 0"):
        Target(**{name: bad})


def test_a_target_names_something() -> None:
    with pytest.raises(ao.SettingsError, match="budget_ms, max_error or both"):
        Target()


# candidates


def test_every_preset_is_a_candidate() -> None:
    for method in PROBES:
        for name in ao.registry()[method].presets:  # type: ignore[attr-defined]
            made = CANDIDATES[f"{method} {name}"][1].made()
            assert made == preset(method, name)
    assert ao.Settings().method in [candidate.made() for _, candidate in CANDIDATES.values()], "and so is the default"


def test_what_the_planner_names_is_there() -> None:
    for one, two in PROBES.values():
        assert CANDIDATES[one][1].layers == 1 and two in CANDIDATES
    assert {FINE, COARSE, DEEP} <= set(CANDIDATES)
    assert len(CANDIDATES) == sum(len(family.values) for family in FAMILIES), "names are unique"
    assert len({family.name for family in FAMILIES}) == len(FAMILIES)


def test_arrays_have_one_layer() -> None:
    assert {c.layers for c in chosen_from([], 1)} == {1} and {c.layers for c in chosen_from([], 2)} == {1, 2}
    assert {c.method for c in chosen_from(["alchemy"], 2)} == {"alchemy"}
    with pytest.raises(ao.SettingsError, match=r"nothing is known of 'bitmsk' to plan by.*Did you mean 'bitmask'"):
        chosen_from(["bitmsk"], 2)


def test_what_would_be_overruled_is_named() -> None:
    assert differing(ao.Alchemy(radius=2.0)) == []
    assert differing(ao.Alchemy(radius=2.0, samples=5, bias=0.01)) == ["samples=5", "bias=0.01"]


# costs

rates = st.builds(CostRate, *[st.floats(0.0, 1e3)] * 4)


@given(rates)
def test_rates_are_found_again(rate: CostRate) -> None:
    places = [(0.03, 0.03), (0.25, 0.25), (0.25, 0.03)]
    frames = [PassWork(area, shaded, taps * shaded) for area, shaded in places for taps in (5, 10)]
    found = fitted([(one, max(rate.ms(one), 1e-3)) for one in frames])
    for one in (*frames, PassWork(1.0, 0.5, 10)):
        assert found.ms(one) == pytest.approx(rate.ms(one), rel=1e-3, abs=0.02)


@given(st.lists(st.tuples(positive, positive, positive, positive), min_size=1, max_size=6))
def test_no_part_of_a_rate_is_negative(runs: list[tuple[float, float, float, float]]) -> None:
    found = fitted([(PassWork(area, min(area, shaded), taps), ms) for area, shaded, taps, ms in runs])
    assert min(dataclasses.astuple(found)) >= 0


NOWHERE = DrawRegion()
SETTINGS = ao.Settings(method=CANDIDATES["bitmask medium"][1].made(1.0))
PLAN = plan_render(SETTINGS, (640, 360))
FRAMED = PlannedFrame(PLAN, NOWHERE, "bitmask", 10)


def test_work_goes_by_what_is_drawn_and_covered() -> None:
    found = FRAMED.works(0.25)
    assert found["gbuffer"] == PassWork(0.2304, 0.2304), "not tested"
    assert found["bitmask"] == PassWork(0.0576, 0.0144, 0.144), "at half size, a quarter of it, ten taps each"
    inside = DrawRegion(image_rect=(16, 16, 608, 328))
    area = dataclasses.replace(FRAMED, region=inside).works(1.0)["bitmask"].area
    assert area == pytest.approx(312e-6 * 172), "with a margin for later passes"
    strip = dataclasses.replace(FRAMED, region=DrawRegion(scene_rect=(0, 0, 640, 36)))
    assert dataclasses.astuple(strip.works(0.5)["bitmask"]) == pytest.approx((0.00576, 0.00576, 0.0576))


def test_a_frame_predicts_itself_and_what_its_rates_say_of_others() -> None:
    ms = {step.task.name: 1.0 + i for i, step in enumerate(PLAN.steps)}
    known = {name: CostRate(0, 10, 0) for name in ms if name not in DRAWN} | {"bitmask": CostRate(0, 0, 0, 1)}
    frame = Measured.of(FRAMED, ms, 1.0, known)
    assert frame.predict(FRAMED, known) == pytest.approx(sum(ms.values()))
    dearer = frame.predict(dataclasses.replace(FRAMED, taps=20), known)
    assert dearer - sum(ms.values()) == pytest.approx(ms["bitmask"]), "twice the taps, twice the time"
    larger = dataclasses.replace(FRAMED, plan=plan_render(SETTINGS, (1280, 720)))
    drawn = sum(ms[name] for name in DRAWN if name in ms)
    assert frame.predict(larger, known) == pytest.approx(2 * drawn + 4 * (sum(ms.values()) - drawn))


def test_a_frame_says_what_it_knows_nothing_of() -> None:
    ms = dict.fromkeys((step.task.name for step in PLAN.steps), 1.0)
    plan = plan_render(ao.Settings(method=CANDIDATES["bitmask ultra"][1].made(1.0)), (640, 360), triangles=12)
    surrounded = PlannedFrame(plan, NOWHERE, "bitmask", 12)
    known = {step.task.name: CostRate(0, 1, 0) for step in plan.steps if "block" not in step.task.name}
    frame = Measured.of(FRAMED, ms, 1.0, known)
    assert not frame.lacks(FRAMED, known) and frame.lacks(surrounded, known)
    other = Measured.of(surrounded, {step.task.name: 2.0 for step in plan.steps}, 1.0, known).beside(frame)
    assert not other.lacks(surrounded, known) and other.passes["upsample"] == frame.passes["upsample"]


# errors


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


def test_nothing_is_wrong_where_nothing_is_seen() -> None:
    empty = view_features(
        *[np.ones((4, 6), np.float32)] * 3, np.zeros((4, 6), np.float32), np.zeros((4, 6, 3), np.float32), VIEW, 1.0
    )
    assert empty == ViewFeatures(0, 0, 0, 0)
    assert all(error_model.predicted(name, empty, 2) == 0 for name in CANDIDATES)


VIEW = ViewConstants((6, 4), ao.Camera.perspective(0.9, 0.1, 10).view((6, 4)).projection)


def test_a_plane_is_not_rough_and_a_step_is() -> None:
    normals = np.broadcast_to(np.array([0, 0, 1], np.float32), (4, 6, 3))
    depth = np.full((4, 6), 2, np.float32)
    assert off_plane(depth, normals, VIEW, 1.0).max() == 0
    depth[:, 3:] = 2.5
    found = off_plane(depth, normals, VIEW, 1.0)
    assert found[:, 2:4] == pytest.approx(0.5) and found[:, [0, 1, 4, 5]].max() < 1e-6
    depth[:, 3:] = 9
    assert off_plane(depth, normals, VIEW, 1.0).max() == 1, "no more than a radius"
    depth[:, 3:] = 0
    assert off_plane(depth, normals, VIEW, 1.0).max() == 0, "background is no neighbour"


def test_signs_are_what_pictures_differ_by() -> None:
    depth, normals = np.full((4, 6), 2, np.float32), np.broadcast_to(np.array([0, 0, 1], np.float32), (4, 6, 3))
    depth[:, 0] = 0
    fine = np.full((4, 6), 0.8, np.float32)
    coarse, deep = fine + 0.1, fine - 0.2
    coarse[:, 0] = deep[:, 0] = 0  # background counts nothing
    found = view_features(fine, coarse, deep, depth, normals, VIEW, 1.0)
    assert (found.sampling, found.hidden, found.rough) == pytest.approx((0.1, 0.2, 0), abs=1e-6)
    assert view_features(fine, coarse, None, depth, normals, VIEW, 1.0).hidden == 0


# cache


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


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"bitmask draft": 3}', "NEGATIVE"])
def test_a_damaged_calibration_is_made_anew(
    tmp_path: Path, probes: list[str], caplog: pytest.LogCaptureFixture, content: str
) -> None:
    found = calibration.calibrated(renderer(), tmp_path)
    (path,) = tmp_path.glob("planner-*.json")
    path.write_text(path.read_text().replace("1", "-1") if content == "NEGATIVE" else content)
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


# command line

GOAL = ("--budget-ms", "50")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--budget-ms", "0"), "budget_ms=0.0: must be a finite number above 0"),
        (("--max-error", "nan"), "max_error=nan: must be"),
        ((*GOAL, "--preset", "high"), "--preset high: --budget-ms and --max-error choose that"),
        ((*GOAL, "--samples", "4", "--method", "alchemy"), "--samples 4: --budget-ms"),
    ],
)
@pytest.mark.parametrize("command", ["render", "explain", "apply"])
def test_bad_targets_are_one_line(
    command: str, arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    needed = ("--depth", "no.npy", "--yfov-deg", "40") if command == "apply" else ()
    assert message in refused(capsys, command, *needed, *arguments)
