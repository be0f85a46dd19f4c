"""The field of occupancy: planes, a ball on paper, the same from every view, what it refuses, and what it costs others."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import FIELD
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.spheres import Spheres

from ..shapes import camera, plane
from ..volumes import half_space

SIZE = (96, 72)


def settings(radius: float, blur: Any = None, **changes: Any) -> ao.Settings:
    return ao.Settings(method=dataclasses.replace(ao.method("field"), radius=radius, **changes), blur=blur)


def seen(renderer: ao.Renderer, scene: Scene, cam: Camera, radius: float, **changes: Any) -> ao.Picture:
    return renderer.render(scene, cam, SIZE, settings(radius, **changes), aovs=("visibility", "depth"), checked=True)


def turned(seed: int) -> np.ndarray:
    """A direction of any kind."""
    n = np.random.default_rng(seed).normal(size=3)
    return n / np.linalg.norm(n)


@pytest.mark.parametrize("tilt", [-1.3, 0.3, 1.0])
def test_planes_of_triangles_are_open(any_renderer: ao.Renderer, tilt: float) -> None:
    assert seen(any_renderer, plane(tilt), camera(), 0.8, detail=4.0).visibility.min() > 0.98


@pytest.mark.parametrize("seed", range(3))
def test_planes_that_bound_a_solid_are_open(any_renderer: ao.Renderer, seed: int) -> None:
    n, affine = turned(seed), np.diag([0.25, 0.25, 0.25, 1.0])
    scene = Scene(volumes=[half_space(affine, n, np.array([4.0, 4.0, 4.0]), (32, 32, 32))])
    up = np.cross(n, [1, 0, 0]) if abs(n[0]) < 0.9 else np.cross(n, [0, 1, 0])
    above = Camera.perspective(0.3, 0.1, 40.0, look_at([4, 4, 4] + 6 * n, [4, 4, 4], up))
    picture = seen(any_renderer, scene, above, 1.0)
    assert (picture.depth > 0).all()
    assert picture.visibility.mean() > 0.98 and picture.visibility.min() > 0.85


def test_a_ball_is_open_and_two_that_touch_are_not(any_renderer: ao.Renderer) -> None:
    one = Scene(spheres=[Spheres(np.zeros((1, 3), np.float32), np.float32(1))])
    eye = Camera.perspective(0.5, 1.0, 20.0, look_at((0, 0, 6), (0, 0, 0), (0, 1, 0)))
    picture = seen(any_renderer, one, eye, 1.0)
    assert picture.visibility[picture.depth > 0].mean() > 0.99
    two = Scene(spheres=[Spheres(np.array([[-1, 0, 0], [1, 0, 0]], np.float32), np.float32(1))])
    assert seen(any_renderer, two, eye, 1.0).visibility[36, 46:50].max() < 0.6


def test_a_ball_above_a_floor_hides_its_form_factor(any_renderer: ao.Renderer) -> None:
    """A point of the floor at the distance s from below a ball of radius r at height h loses r^2 h / (s^2 + h^2)^(3/2)."""
    r, h = 1.0, 1.6
    floor = plane().meshes[0]
    spheres = Spheres(np.array([[0, 0, -5 + h]], np.float32), np.float32(r))
    eye = Camera.perspective(0.7, 0.1, 40.0, look_at((4, 0, 1), (1.5, 0, -5), (0, 1, 0)))
    scene = Scene([floor], spheres=[spheres])
    picture = seen(any_renderer, scene, eye, 6.0, blur=ao.Joint(), cones=16, voxel=0.15)
    view = eye.view(SIZE)
    points = view.points(picture.depth).reshape(-1, 3) @ eye.pose[:3, :3].T + eye.pose[:3, 3]
    on_floor = np.abs(points[:, 2] + 5) < 1e-3
    s2 = (points[on_floor, :2] ** 2).sum(1)
    exact = 1 - r * r * h / (s2 + h * h) ** 1.5
    error = picture.visibility.reshape(-1)[on_floor] - exact
    assert on_floor.sum() > 1000 and (exact < 0.75).sum() > 50
    assert abs(error.mean()) < 0.03 and np.sqrt((error**2).mean()) < 0.05


def test_a_point_is_as_dark_from_every_view(any_renderer: ao.Renderer) -> None:
    """The middle of the picture shows one point of one ball, from three sides."""
    spheres = Spheres(np.array([[0, 0, 0], [2.4, 0, 0.6]], np.float32), np.float32(1))
    scene, point = Scene(spheres=[spheres]), np.array([0.8, 0.0, 0.6])
    found = []
    for eye in ((2.0, 4.0, 4.0), (0.3, -1.0, 5.0), (1.2, 3.0, 3.0)):
        cam = Camera.perspective(0.05, 0.5, 20.0, look_at(eye, point, (0, 0, 1)))
        found.append(seen(any_renderer, scene, cam, 1.5, blur=ao.Joint(), cones=16).visibility[30:42, 42:54].mean())
    assert max(found) < 0.95 and max(found) - min(found) < 0.02


def test_one_field_serves_every_view_and_is_said(any_renderer: ao.Renderer) -> None:
    scene = Scene(spheres=[Spheres(np.zeros((1, 3), np.float32), np.float32(1))])
    eyes = [Camera.perspective(0.5, 1.0, 20.0, look_at(eye, (0, 0, 0), (0, 1, 0))) for eye in ((0, 0, 6), (6, 0, 0))]
    reports = [any_renderer.render(scene, eye, SIZE, settings(1.0), aovs=("visibility",)).report for eye in eyes]
    assert reports[0]["prepared"] == reports[1]["prepared"] and reports[0]["prepared"]["bytes"] > 0
    plain = any_renderer.render(scene, eyes[0], SIZE, ao.Settings(), aovs=("visibility",))
    assert "prepared" not in plain.report and FIELD not in plan_render(ao.Settings().with_radius(1.0), SIZE).inputs


def test_scenes_too_large_for_their_radius_get_larger_voxels(any_renderer: ao.Renderer) -> None:
    ball = Scene(spheres=[Spheres(np.array([[0, 0, -5], [900, 0, 0]], np.float32), np.float32(1))])
    picture = any_renderer.render(ball, camera(), SIZE, settings(0.1), aovs=("visibility",))
    assert 0.5 < picture.report["settings"]["field"]["voxel"] < 1.5 and picture.visibility.min() > 0.9


def test_a_depth_buffer_is_refused_in_one_line() -> None:
    with ao.Renderer() as renderer, pytest.raises(ao.SettingsError, match=r"^field: needs a scene to draw; use render, or"):
        renderer.apply(np.ones((8, 8), np.float32), camera(), settings=settings(1.0))


@pytest.mark.parametrize(
    ("changes", "told"), [({"scale": 3}, "field.scale=3: must be"), ({"cones": 0}, "cones"), ({"voxel": 0}, "voxel")]
)
def test_wrong_settings_are_refused(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ao.SettingsError, match=told):
        settings(1.0, **changes)
