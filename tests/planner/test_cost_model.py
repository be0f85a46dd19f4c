"""Tests of ``planner/cost_model.py``."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

import ssao_gl as ao
from ssao_gl.graph.regions import DrawRegion
from ssao_gl.pipeline.build import plan_render
from ssao_gl.planner.candidates import CANDIDATES
from ssao_gl.planner.cost_model import DRAWN, CostRate, Measured, PassWork, PlannedFrame, fitted

from .test_choice import positive

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
