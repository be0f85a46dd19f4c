"""Light of one bounce that is gathered beside occlusion: against rays, with any method, and nothing of it where nobody asks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import BOUNCE, DEPTH, GAINED, SHADOW_COLOR, SHADOW_NORMAL
from ssao_gl.pipeline.build import plan_render
from ssao_gl.pipeline.light import Light, lit_view
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lamps import Lamp
from ssao_gl.scene.spheres import Spheres
from ssao_gl.truth.bounce import one_bounce
from ssao_gl.truth.surface import surface

from ..shapes import look_at
from .test_light import ROOM_CAMERA, SIZE, linear, room, settings

KEY = {"intensity": 1.0, "shadows": True, "azimuth": 50.0, "elevation": 40.0}


def gathering(indirect: str, **method: object) -> ao.Settings:
    return dataclasses.replace(
        settings(**KEY, indirect=indirect),
        method=ao.Bitmask(**{"radius": 0.8, "guard": 0.0, **method}),  # type: ignore[arg-type]
    )


def gained(renderer: ao.Renderer, scene: ao.Scene, camera: Camera, how: ao.Settings) -> np.ndarray:
    light, depth = (renderer.resource(scene, camera, SIZE, how, name, aovs=("image",))[::-1] for name in (GAINED, DEPTH))  # type: ignore[index]
    return light[..., :3].astype(np.float64) * (depth.reshape(light.shape[:2]) > 0)[..., None]


@pytest.mark.parametrize(("indirect", "rmse", "energy"), [("rsm", 0.028, (0.85, 1.05)), ("ssdo", 0.05, (0.45, 1.0))])
@pytest.mark.parametrize("preset", ["draft", "ultra"])
def test_gathered_light_is_that_of_rays(
    any_renderer: ao.Renderer, indirect: str, rmse: float, energy: tuple[float, float], preset: str
) -> None:
    how = gathering(indirect, **{**ao.Bitmask.presets[preset], "layers": 1})
    light = gained(any_renderer, room(), ROOM_CAMERA, how)
    seen = surface(room(), ROOM_CAMERA, SIZE)
    sun = lit_view(how.light, room(), ROOM_CAMERA, SIZE).eyes["key light"][0].pose[:3, 2]
    truth = one_bounce(seen, sun, 0.8, rays=32)[seen.covered]
    light = light[seen.covered]
    assert truth.max() > 0.1
    assert np.sqrt(np.mean((light - truth) ** 2)) <= rmse
    assert energy[0] <= light.sum() / truth.sum() <= energy[1]
    np.testing.assert_allclose(light.sum(0) / light.sum(), truth.sum(0) / truth.sum(), rtol=0.1)


@pytest.mark.parametrize("indirect", ["ssdo", "rsm"])
def test_it_goes_with_any_method_that_has_noise(renderer: ao.Renderer, indirect: str) -> None:
    for method, blur in ((ao.Alchemy(radius=0.8), ao.Joint()), (ao.Alchemy(radius=0.8, tile=1), None)):
        pictures = [
            linear(renderer.render(room(), ROOM_CAMERA, SIZE, dataclasses.replace(how, method=method, blur=blur), checked=True))
            for how in (gathering("none"), gathering(indirect))
        ]
        more = pictures[1] - pictures[0]
        assert more.min() >= 0.0  # it is added to what there was
        assert (more[..., 0] - more[..., 1]).max() > 0.02  # the red wall's


def test_units_of_the_scene_do_not_matter(any_renderer: ao.Renderer) -> None:
    camera, scene, how = ROOM_CAMERA, room(), gathering("rsm")
    meshes = [dataclasses.replace(mesh, positions=1024 * mesh.positions) for mesh in scene.meshes]
    pose = camera.pose.copy()
    pose[:3, 3] *= 1024
    far = Camera.perspective(0.7, 102.4, 20480.0, pose)
    larger = dataclasses.replace(how, method=dataclasses.replace(how.method, radius=819.2))
    both = gained(any_renderer, scene, camera, how), gained(any_renderer, ao.Scene(meshes), far, larger)
    assert both[0].max() > 0.1
    assert np.mean(np.abs(both[0] - both[1]) > 2e-3) < 0.01


def test_lamps_of_the_scene_and_things_that_are_no_meshes(any_renderer: ao.Renderer) -> None:
    # A red ball beside a white one: the sun comes over from behind the white one.
    balls = [
        Spheres(centers=np.array([[x, 0, 0]]), radii=np.array([0.5]), color=c) for x, c in ((-0.5, (1, 0, 0)), (0.5, (1, 1, 1)))
    ]
    lamps = [Lamp("directional", (1.0, 1.0, 1.0), direction=(-0.8, -0.6, 0.0)), Lamp("point", (1.0, 1.0, 1.0), place=(0, 3, 0))]
    scene = dataclasses.replace(ao.Scene(balls), lamps=lamps)
    camera = Camera.perspective(0.5, 0.1, 20.0, look_at((0, 0, 5), (0, 0, 0)))
    how = gathering("rsm")
    how = dataclasses.replace(how, light=dataclasses.replace(how.light, lamps="scene"))  # type: ignore[type-var]
    light = gained(any_renderer, scene, camera, how)
    white = light[:, 64:]
    assert white[..., 0].max() > 0.01 and white[..., 1].max() < 1e-3  # of the red ball alone
    dark = dataclasses.replace(scene, lamps=lamps[1:])
    with pytest.raises(ao.SettingsError, match="indirect=rsm: no lamp of the scene is directional; use --light"):
        any_renderer.render(dark, camera, SIZE, how)


def test_nothing_of_it_where_nobody_asks() -> None:
    for indirect in ("none", "tint", "bitmask"):
        plan = plan_render(gathering(indirect), SIZE)
        assert not {SHADOW_NORMAL, SHADOW_COLOR} & set(plan.where)
        assert "gathered light" not in [step.task.name for step in plan.steps]
    assert BOUNCE not in plan_render(gathering("rsm"), SIZE).where
    seen = plan_render(gathering("ssdo"), SIZE)
    assert BOUNCE in seen.where and SHADOW_COLOR not in seen.where
    assert [step.task.name for step in seen.steps].count("gathered light") == 1


@pytest.mark.parametrize(
    ("how", "message"),
    [
        (dataclasses.replace(gathering("rsm"), light=Light(indirect="rsm")), "indirect=rsm: gathers from a shadow map"),
        (dataclasses.replace(gathering("rsm"), light=Light(indirect="rsm", shadows=True, intensity=0.0)), "with a key light"),
        (dataclasses.replace(gathering("ssdo"), method=ao.method("vom", radius=1.0)), "vom lacks them; use bitmask"),
        (dataclasses.replace(gathering("ssdo"), blur=ao.Separable()), "indirect: the filter separable is for visibility alone"),
    ],
)
def test_what_cannot_be_gathered(how: ao.Settings, message: str) -> None:
    with pytest.raises(ao.SettingsError, match=message):
        plan_render(how, SIZE)
