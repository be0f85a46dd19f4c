"""Things that receive no occlusion, things that cast none, and nothing when all do both."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.material import Material
from ssao_gl.scene.model import Scene

from ..command_line import refused
from ..shapes import camera, quad

SIZE = (96, 72)
WALL = dataclasses.replace(quad((0, 0, -5), (40, 0, 0), (0, 40, 0)), name="wall")
SHEET = dataclasses.replace(quad((0, 0, -4.6), (0.3, 0, 0.38), (0, 0.6, 0)), name="sheet", material=Material(name="glass"))
BOTH, ALONE = Scene([WALL, SHEET]), Scene([WALL])
METHODS = [
    ao.Bitmask(radius=0.8),
    ao.Bitmask(radius=0.8, scale=1),
    ao.Bitmask(radius=0.8, layers=2, layer_scale=2, refine=0.02),
]


def drawn(renderer: ao.Renderer, scene: Scene, *exclude: str, method: Any = METHODS[0], **more: Any) -> ao.Picture:
    settings = ao.Settings(method=method, exclude=exclude, **more)
    return renderer.render(scene, camera(), SIZE, settings, aovs="visibility,object", checked=True)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["sheet", "sh*", "glass"])
def test_what_receives_none_is_open_and_the_rest_as_it_was(any_renderer: ao.Renderer, method: Any, name: str) -> None:
    found, plain = (drawn(any_renderer, BOTH, *names, method=method) for names in ((name,), ()))
    sheet = plain.object == 2
    assert (found.visibility[sheet] == 1).all() and (found.visibility[~sheet] == plain.visibility[~sheet]).all()
    assert plain.visibility[~sheet].min() < 0.9


@pytest.mark.parametrize("method", METHODS)
def test_what_casts_none_leaves_the_others_as_if_alone(any_renderer: ao.Renderer, method: Any) -> None:
    found, plain = (drawn(any_renderer, BOTH, *names, method=method) for names in (("sheet:casts",), ()))
    alone = drawn(any_renderer, ALONE, method=method)
    beside = plain.object == 1
    assert np.abs(found.visibility - alone.visibility)[beside].max() <= 2 / 255 and plain.visibility[beside].min() < 0.8
    assert found.visibility[~beside].mean() < 0.99, "the wall that it stands on still darkens it"


def test_nothing_excluded_costs_nothing() -> None:
    settings = ao.Settings(method=METHODS[0])
    plan = plan_render(settings, SIZE)
    assert "exclude" not in plan.describe() and "caster" not in plan.describe() and "exclude" not in settings.table()
    names = [step.task.name for step in plan_render(dataclasses.replace(settings, exclude=("a:casts",)), SIZE).steps]
    assert "caster depth" in names and "receiver depth" not in names and "exclude" not in names


def test_names_are_a_list_of_texts() -> None:
    assert ao.Settings(exclude=["a"]).exclude == ("a",)  # type: ignore[arg-type]
    for wrong in ("glass", ("",), (1,)):
        with pytest.raises(ao.SettingsError, match="must be names"):
            ao.Settings(exclude=wrong)  # type: ignore[arg-type]


@pytest.mark.gl
def test_what_cannot_be_excluded_is_told_in_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    small = ("render", "--size", "32x24", "--exclude")
    assert "nothing in embedded scene is called so" in refused(capsys, *small, "ball")
    assert "looks at what is seen alone" in refused(capsys, *small, "balls:casts", "--method", "alchemy")
    assert "rays meet all things alike" in refused(capsys, *small, "balls", "--rays", "1")
