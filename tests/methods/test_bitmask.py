"""The flagship against closed forms and integrals: presets as shipped, filter and smaller targets included."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.methods.bitmask import FALLOFFS
from ssao_gl.sampling.falloff import rho
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.truth.closed_forms import closed_forms

from ..shapes import camera, plane, quad

STEP = 1 / 255 + 1e-6
GOOD = ("medium", "high", "ultra")
WIDE = Camera.perspective(0.65, 0.1, 100.0, look_at((5, 4.6, 0), (0.4, 0.4, 0)))
"""It sees more than a radius around floor and wall."""


def draw(
    renderer: ao.Renderer, scene: Scene, cam: Camera, size: tuple[int, int], preset: str = "medium", **changes: Any
) -> Any:
    method = ao.Bitmask(**{**ao.Bitmask.presets[preset], **changes})
    return renderer.render(scene, cam, size, ao.Settings(method=method), aovs=("visibility", "depth"), checked=True)


def places(picture: Any, cam: Camera) -> np.ndarray:
    """World points of the pixels (h, w, 3)."""
    h, w = picture.depth.shape
    points: np.ndarray = cam.view((w, h)).points(picture.depth) @ cam.pose[:3, :3].T + cam.pose[:3, 3]
    return points


@pytest.mark.parametrize("preset", GOOD)
def test_a_wall_within_a_hard_radius(any_renderer: ao.Renderer, preset: str) -> None:
    form = closed_forms()["wall"]
    picture = draw(any_renderer, form.scene, WIDE, (640, 480), preset, radius=form.radius)
    points = places(picture, WIDE)
    expected = form.visibility(points.reshape(-1, 3)).reshape(picture.depth.shape)
    off = (picture.visibility - expected)[picture.depth > 0]
    assert np.ptp(expected) > 0.45
    assert abs(off.mean()) <= 0.005
    assert np.quantile(np.abs(off), 0.99) <= 0.03


def corner_by_rays(distance: float, falloff: str) -> float:
    """Visibility on a floor, ``distance`` radii from a wall at right angles that never ends, over evenly spread rays."""
    u, phi = np.meshgrid((np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(800) + 0.5) / 800)
    toward = np.sqrt(u) * np.cos(phi)
    hit = np.where(toward > 0, distance / np.maximum(toward, 1e-9), np.inf)
    return float(1 - rho(falloff, hit).mean())


@pytest.mark.parametrize("falloff", FALLOFFS)
def test_falloffs_are_those_of_the_rays(any_renderer: ao.Renderer, falloff: str) -> None:
    """Along a floor at the foot of a wall, up to the radius."""
    form = closed_forms()["wall"]
    picture = draw(any_renderer, form.scene, WIDE, (640, 480), "high", radius=form.radius, falloff=falloff)
    points = places(picture, WIDE)
    floor = (picture.depth > 0) & (points[..., 1] < 1e-3)
    for share in (0.15, 0.3, 0.5, 0.8):
        there = floor & (np.abs(points[..., 0] / form.radius - share) < 0.02)
        assert there.sum() > 100
        assert picture.visibility[there].mean() == pytest.approx(corner_by_rays(share, falloff), abs=0.03)


@pytest.mark.parametrize("preset", list(ao.Bitmask.presets))
def test_flat_and_gently_curved_surfaces_are_free_of_noise(any_renderer: ao.Renderer, preset: str) -> None:
    ball = trimesh.creation.uv_sphere(radius=30.0, count=[256, 256])
    ball.apply_translation((0, 0, -35))
    scenes = [plane(0.9), Scene([Mesh(ball.vertices.astype(np.float32), ball.faces.astype(np.uint32), None)])]
    for scene in scenes:
        picture = draw(any_renderer, scene, camera(100.0), (320, 180), preset, radius=1.0)
        seen = picture.visibility[picture.depth > 0]
        assert seen.size > 50_000
        assert seen.std() <= 0.5 / 255


@pytest.mark.parametrize("preset", GOOD)
def test_the_size_of_the_image_does_not_matter(any_renderer: ao.Renderer, embedded: Scene, preset: str) -> None:
    means = []
    for size in ((320, 180), (640, 360), (1280, 720)):
        picture = draw(any_renderer, embedded, embedded.cameras[0], size, preset, radius=0.7)
        means.append(picture.visibility[picture.depth > 0].mean())
    assert np.ptp(means) <= 0.005


@pytest.mark.parametrize("preset", list(ao.Bitmask.presets))
def test_no_halo_of_a_bar_far_before_a_wall(any_renderer: ao.Renderer, preset: str) -> None:
    """Farther than the veil, and wider than a pixel of every target."""
    bar = quad((0, 0, -1.9), (0.04, 0, 0), (0, 40, 0))
    picture = draw(any_renderer, Scene([*plane().meshes, bar]), camera(), (320, 180), preset, radius=1.0)
    assert (np.abs(picture.depth - 1.9) < 1e-3).sum() > 180
    assert picture.visibility.min() >= 1 - STEP


@pytest.mark.parametrize("preset", list(ao.Bitmask.presets))
def test_the_rim_of_what_may_hide_something_is_faint(any_renderer: ao.Renderer, preset: str) -> None:
    """Twice the radius before a wall, where nothing hides anything: in the mean of the band within a radius around it."""
    scene = Scene([quad((0, 0, -12), (30, 0, 0), (0, 30, 0)), quad((0, 0, -10), (1.5, 0, 0), (0, 40, 0))])
    picture = draw(any_renderer, scene, camera(), (640, 360), preset, radius=1.0)
    wall, aside = picture.depth > 11, np.abs(places(picture, camera())[..., 0])
    edge = 1.5 * 12 / 10  # where the bar's edge is seen on the wall
    band = wall & (aside < edge + 1)
    assert band.sum() > 1000
    assert 0 <= 1 - picture.visibility[band].mean() <= (8 if preset == "draft" else 6) / 255
    assert picture.visibility[wall & (aside > edge + 1.1)].min() >= 1 - STEP


def test_arrays_have_one_layer(renderer: ao.Renderer, embedded: Scene) -> None:
    """Presets that look behind the first layer draw a depth image as if there were no more."""
    cam, size = embedded.cameras[0], (160, 120)
    depth = renderer.render(embedded, cam, size, aovs=("depth",)).depth
    for name in ("high", "ultra"):
        two = ao.Bitmask(**{**ao.Bitmask.presets[name], "radius": 0.5})
        seen = [
            renderer.apply(depth=depth, camera=cam, settings=ao.Settings(method=method)).visibility
            for method in (two, dataclasses.replace(two, layers=1))
        ]
        assert seen[0].min() < 0.8 and np.array_equal(*seen)


@pytest.mark.parametrize("preset", list(ao.Bitmask.presets))
def test_no_rim_at_the_sky(any_renderer: ao.Renderer, preset: str) -> None:
    """A box on its corner: nothing of it hides anything of it."""
    box = trimesh.creation.box((2, 2, 2))
    box.apply_transform(trimesh.transformations.euler_matrix(0.7, 0.5, 0.3))
    box.apply_translation((0, 0, -6))
    picture = draw(any_renderer, Scene.from_arrays(box.vertices, box.faces), camera(), (320, 180), preset, radius=1.0)
    assert 3000 < (picture.depth > 0).sum() < 40_000
    assert picture.visibility.min() >= 1 - STEP


def test_thin_parts_hide_no_more_than_they_are_thick(any_renderer: ao.Renderer) -> None:
    """Light comes in behind a bar before a wall, which a horizon, taking the bar for endlessly thick, shuts out."""
    scene = Scene([*plane().meshes, quad((0, 0, -4.2), (0.06, 0, 0), (0, 40, 0))])
    lost = {}
    for thickness in (0.1, 1000.0):
        picture = draw(any_renderer, scene, camera(), (640, 360), "high", radius=1.0, thickness=thickness, bridge=0.0)
        lost[thickness] = 1 - picture.visibility[np.abs(picture.depth - 5) < 0.01].mean()
    assert 0 < lost[0.1] < 0.6 * lost[1000.0], lost


@pytest.mark.parametrize(
    "changes", [{"scale": 3}, {"tile": 5}, {"slices": 0}, {"falloff": "soft"}, {"thickness": float("nan")}]
)
def test_settings_out_of_range(changes: dict[str, Any]) -> None:
    with pytest.raises(ao.SettingsError, match=f"bitmask.{next(iter(changes))}="):
        dataclasses.replace(ao.Bitmask(), **changes)
