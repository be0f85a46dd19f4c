"""Rays correct what the screen cannot know: closed forms, the way to the truth, and that nothing changes without them."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.experiment.estimators import ScreenSpace
from ssao_gl.experiment.residual import ResidualRays, residual_rays_upon
from ssao_gl.graph.draws import HostWork
from ssao_gl.graph.names import RAYS
from ssao_gl.graph.plan_json import plan_from_json, plan_to_json
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.truth import Tracing, trace

from ..conftest import openable
from ..shapes import camera, corner, look_at, plane, quad

pytest.importorskip("embreex")
pytest.importorskip("scipy")

SIZE = (160, 90)
LARGE = (320, 180)
"""Large enough for a filter ten pixels wide."""


def with_rays(share: float, method: Any = None, **changes: Any) -> ao.Settings:
    return ao.Settings(method=method or ao.Bitmask(radius=0.7), rays=share, **changes)


def drawn(
    renderer: ao.Renderer, scene: Scene, cam: Camera, share: float, size: tuple[int, int] = SIZE, **changes: Any
) -> np.ndarray:
    return renderer.render(scene, cam, size, with_rays(share, **changes), aovs=("visibility",), checked=True).visibility


@pytest.mark.parametrize("share", [0.25, 2.0])
@pytest.mark.parametrize("tilt", [0.0, 0.7, 1.5])
def test_a_plane_stays_open_at_any_tilt(renderer: ao.Renderer, share: float, tilt: float) -> None:
    for cam in (camera(), Camera.orthographic(8.0, 0.1, 40.0)):
        assert (drawn(renderer, plane(tilt), cam, share, method=ao.Bitmask(radius=2.0)) == 1).all()


def test_a_ceiling_that_no_camera_sees(renderer: ao.Renderer) -> None:
    """Below a ceiling at height h visibility is 1 - (1 - (h / R)^2) under a hard radius R (the sine squared of the angle to its rim)."""
    scene = Scene([quad((0, 0, -5), (40, 0, 0), (0, 40, 0)), quad((0, 0, 1), (40, 0, 0), (0, 40, 0))])
    method, exact = ao.Bitmask(radius=8.0), (6 / 8) ** 2
    screen, quarter, two = (drawn(renderer, scene, camera(), share, method=method)[20:-20, 20:-20] for share in (0, 0.25, 2))
    assert (screen == 1).all(), "what stands behind the camera is not on the screen"
    assert quarter.mean() == pytest.approx(exact, abs=0.06) and two.mean() == pytest.approx(exact, abs=0.025)
    assert np.abs(two - exact).max() < 0.1


@pytest.mark.parametrize("falloff", ["hard", "quadratic"])
def test_the_more_rays_the_nearer_to_the_truth(any_renderer: ao.Renderer, embedded: Scene, falloff: str) -> None:
    cam = embedded.cameras[0]
    truth = trace(embedded, cam, LARGE, Tracing(radius=0.7, falloff=falloff, spp=1024))
    method = ao.Bitmask(radius=0.7, falloff=falloff)

    def error(share: float) -> float:
        off = drawn(any_renderer, embedded, cam, share, LARGE, method=method) - truth.visibility
        return float(np.sqrt(np.mean(off[truth.covered] ** 2)))

    found = [error(share) for share in (0, 0.25, 1, 8, 64, 512)]
    assert (np.diff(found) < 0).all() and found[1] < 0.95 * found[0] and found[-1] < 0.015, found


def test_as_many_pixels_are_traced_as_asked(any_renderer: ao.Renderer) -> None:
    for share in (0.1, 0.25, 1.5):
        count = any_renderer.resource(plane(0.3), camera(), SIZE, with_rays(share), RAYS)
        assert count is not None and np.floor(count).sum() == pytest.approx(share * SIZE[0] * SIZE[1], rel=0.02)
    blocks = np.floor(any_renderer.resource(plane(), camera(), SIZE, with_rays(0.25), RAYS)).reshape(45, 2, 80, 2).sum((1, 3))  # type: ignore[arg-type]
    assert (blocks == 1).all()


def test_the_same_bytes_again(any_renderer: ao.Renderer, embedded: Scene) -> None:
    first = drawn(any_renderer, embedded, embedded.cameras[0], 0.3)
    with ao.Renderer(openable()[0]) as other:
        drawn(other, embedded, embedded.cameras[0], 4.0)  # what was drawn before does not matter
        assert drawn(other, embedded, embedded.cameras[0], 0.3).tobytes() == first.tobytes()


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (37, 21)])
def test_odd_sizes(any_renderer: ao.Renderer, embedded: Scene, size: tuple[int, int]) -> None:
    for share in (0.01, 0.25, 1.0):
        seen = drawn(any_renderer, embedded, embedded.cameras[0], share, size)
        assert np.isfinite(seen).all() and seen.min() >= 0 and seen.max() <= 1


def test_a_camera_that_sees_nothing_or_little(any_renderer: ao.Renderer) -> None:
    away = camera(pose=look_at((9, 9, 9), (18, 18, 18)))
    speck = Scene([quad((0, 0, -5), (0.05, 0, 0), (0, 0.05, 0))])
    for scene, cam in ((plane(), away), (speck, camera())):
        assert (drawn(any_renderer, scene, cam, 0.25) == 1).all()


@pytest.mark.parametrize("name", ["draft", "high", "ultra"])
def test_every_preset_comes_nearer(any_renderer: ao.Renderer, embedded: Scene, name: str) -> None:
    cam = embedded.cameras[0]
    truth = trace(embedded, cam, LARGE, Tracing(radius=0.7, spp=256))
    method = dataclasses.replace(ao.Bitmask(radius=0.7), **ao.Bitmask.presets[name])
    off = [
        np.abs(drawn(any_renderer, embedded, cam, share, LARGE, method=method) - truth.visibility).mean() for share in (0, 1)
    ]
    assert off[1] < (0.9 if name == "ultra" else 0.8) * off[0]


def test_without_rays_nothing_is_there() -> None:
    settings = with_rays(0.0)
    assert "rays" not in settings.table() and settings == ao.Settings(method=ao.Bitmask(radius=0.7))
    plan = plan_render(settings, SIZE, ("image", "visibility"))
    assert not any(isinstance(step.task.draw, HostWork) or "residual" in step.task.name for step in plan.steps)
    wanted = plan_render(with_rays(0.25), SIZE, ("depth",))
    assert [step.task.name for step in wanted.steps] == ["gbuffer"], "nor where nobody looks at visibility"


def test_the_call_of_one_line_takes_them(embedded: Scene) -> None:
    made = ao.render(embedded, size=SIZE, rays=0.25, aovs="visibility")
    assert made.report["settings"]["rays"] == 0.25 and any("residual filter" in line for line in made.report["plan"])
    with pytest.raises(TypeError, match="unexpected keyword argument 'ray'"):
        ao.render(embedded, size=SIZE, ray=None)  # type: ignore[call-arg]


def test_plans_with_rays_are_data() -> None:
    plan = plan_render(with_rays(0.25), SIZE, ("image",))
    assert plan_from_json(plan_to_json(plan)) == plan
    assert plan != plan_render(with_rays(0.5), SIZE, ("image",))


def test_rays_are_a_pass_with_a_time(any_renderer: ao.Renderer, embedded: Scene) -> None:
    made = any_renderer.render(embedded, None, SIZE, with_rays(0.25), aovs=("visibility",), timed=1)
    roles = {one["name"]: one["role"] for one in made.report["passes"]}
    assert roles["rays"] == "occlusion" and roles["residual filter"] == "denoise" and made.report["settings"]["rays"] == 0.25


@pytest.mark.parametrize("rays", [-0.1, float("nan"), float("inf"), 5000, "many"])
def test_bad_shares(rays: Any) -> None:
    with pytest.raises(SettingsError, match=r"rays=.*must be"):
        ao.Settings(rays=rays)


def test_who_has_no_scene_refuses(any_renderer: ao.Renderer) -> None:
    with pytest.raises(SettingsError, match=r"rays=0\.25: apply has a depth buffer and no scene"):
        any_renderer.apply(np.ones((8, 8), np.float32), camera(), settings=with_rays(0.25))
    with pytest.raises(SettingsError, match="rays=1: Effect has a depth buffer and no scene"):
        ao.Effect(any_renderer.ctx.mgl, (8, 8), with_rays(1.0))
    with pytest.raises(SettingsError, match="rays: lecture has a radius in share of the image"):
        plan_render(with_rays(1.0, ao.Lecture()), SIZE)
    with pytest.raises(SettingsError, match="leave rays out"):
        ao.plan(any_renderer, corner(), camera(), SIZE, ao.Target(max_error=0.1), with_rays(1.0, ao.Bitmask()))


def test_without_embreex_one_line_says_so(any_renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex", None)
    with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[truth\]'"):
        drawn(any_renderer, corner(), camera(), 0.25)


def test_what_the_report_measures() -> None:
    methods = [ScreenSpace("bitmask", name, ao.Settings()) for name in ("medium", "ultra")]
    found = residual_rays_upon(methods, ["medium+1/4", "1"])
    assert [one.label for one in found] == ["bitmask medium + rays 1/4", "bitmask medium + rays 1", "bitmask ultra + rays 1"]
    assert isinstance(found[0], ResidualRays) and found[0].share == 0.25 and found[0].table()["rays"] == 0.25
    for text, why in (("0", "above 0"), ("high+1", "no such preset"), ("medium+x", "must be a number")):
        with pytest.raises(SettingsError, match=why):
            residual_rays_upon(methods, [text])
