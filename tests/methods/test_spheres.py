"""Spheres at two levels: the far one against closed forms, where the levels meet, what stands for surfaces, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import ContextError
from ssao_gl.gl.context import Context
from ssao_gl.gl.executor import FrameExecutor, SceneView
from ssao_gl.gl.scene_buffers import SceneBuffers
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.names import HIDDEN
from ssao_gl.passes.elements import add_elements
from ssao_gl.passes.gbuffer import gbuffer
from ssao_gl.scene import ball_elements as balls
from ssao_gl.scene.model import Scene
from ssao_gl.scene.sample_scene import default_scene

from ..shapes import corner, look_at, plane, quad

SIZE = (64, 48)
DOWN = ao.Camera.orthographic(2.0, 0.0, 20.0, look_at((0, 9, 0), (0, 0, 0), (0, 0, -1)))
"""Sees the floor y = 0 from above: 2 units high."""
FLOOR = quad((0, 0, 0), (20, 0, 0), (0, 0, -20))


def settings(radius: float = 10.0, **changes: Any) -> ao.Settings:
    given = {"scale": 1, "near": 0.0, "radius": radius} | changes
    return ao.Settings(method=dataclasses.replace(ao.method("spheres"), **given), blur=None)


def seen(renderer: ao.Renderer, scene: Scene, camera: ao.Camera = DOWN, **changes: Any) -> np.ndarray:
    return renderer.render(scene, camera, SIZE, settings(**changes), aovs=("visibility",), checked=True).visibility


def floor_distance() -> np.ndarray:
    """Of the floor's pixels from the origin, as :data:`DOWN` sees them."""
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32, np.arange(48) + 0.5 - 24)
    return np.asarray(np.hypot(x, y) / 24)


def over_floor(height: float, radius: float) -> Scene:
    return Scene([FLOOR], spheres=[ao.Spheres.from_points([(0, height, 0)], radius)])


@pytest.mark.parametrize("radius", [0.1, 0.25])
def test_a_sphere_above_a_plane_is_exact(any_renderer: ao.Renderer, radius: float) -> None:
    """``(r/d)^2 cos theta`` = ``r^2 h / d^3`` within 2e-3, the lift of receivers and the half floats of the result."""
    height, s = 0.5, floor_distance()
    around = s > 2 * radius  # not the sphere itself
    visibility = seen(any_renderer, over_floor(height, radius))
    exact = 1 - radius**2 * height / (s**2 + height**2) ** 1.5
    assert exact[around].min() < 0.98 and np.abs(visibility - exact)[around].max() < 2e-3


def test_a_sphere_that_dips_below_the_horizon_counts_above_it(renderer: ao.Renderer) -> None:
    """Half a sphere, its middle in the plane: ``(a - sin a cos a) / pi`` where a is its angle."""
    s = floor_distance()
    around = s > 0.35
    angle = np.arcsin(np.minimum(0.3 / s, 1))
    exact = 1 - (angle - np.sin(angle) * np.cos(angle)) / math.pi
    assert np.abs(seen(renderer, over_floor(0.0, 0.3), radius=1.5) - exact)[around].max() < 5e-3


def test_a_ray_counts_up_to_the_radius(renderer: ao.Renderer) -> None:
    """Straight below a sphere of 0.5 whose nearest point is 1 away, as a camera sees it that lies between: the cone of rays no longer than R."""
    for radius in (0.9, 1.05, 1.3, 3.0):
        low = ao.Camera.orthographic(0.1, 0.0, 5.0, look_at((0, 0.5, 0), (0, 0, 0), (0, 0, -1)))
        cosine = (radius**2 + 1.5**2 - 0.5**2) / (2 * radius * 1.5)
        expected = 0.0 if radius <= 1 else 1 - cosine**2 if radius**2 < 2 else (0.5 / 1.5) ** 2
        found = 1 - seen(renderer, over_floor(1.5, 0.5), low, radius=radius)[24, 32]
        assert found == pytest.approx(expected, abs=3e-3), radius


def test_levels_meet_without_counting_twice(renderer: ao.Renderer) -> None:
    """What rays below the near range meet and what those beyond it meet add up, for a sphere of which taps see the top alone."""
    scene, ring = over_floor(0.7, 0.4), (floor_distance() > 0.45) & (floor_distance() < 0.9)
    below, beyond, all_ = (1 - seen(renderer, scene, radius=r, near=near) for r, near in ((0.6, 0.0), (2.0, 0.3), (2.0, 0.0)))
    assert below[ring].mean() > 0.01 and beyond[ring].mean() > 0.01
    assert np.abs(below + beyond - all_)[ring].max() < 3e-3


def test_walls_of_patches_darken_their_corner_as_rays_do(renderer: ao.Renderer) -> None:
    """Against the wall's closed form, by far spheres alone and by both levels: .03 in the mean."""
    cam = ao.Camera.perspective(0.9, 0.1, 40.0)
    depth = renderer.render(corner(), cam, SIZE, settings(), aovs=("depth",)).depth
    points = cam.view(SIZE).points(depth.astype(np.float64))
    k = np.minimum(np.abs(points[..., 0]) * math.sqrt(2) / 1.5, 1)
    exact = 1 - (np.arccos(k) - k * np.sqrt(1 - k**2)) / np.pi
    for near in (0.0, 0.3, 0.7, 1.0):
        visibility = seen(renderer, corner(), cam, radius=1.5, near=near)
        assert exact.min() < 0.7 and np.abs(visibility - exact).mean() < 0.03, near


@pytest.mark.parametrize("near", [0.0, 0.3])
def test_a_plane_does_not_hide_itself(any_renderer: ao.Renderer, near: float) -> None:
    cam = ao.Camera.perspective(0.9, 0.1, 40.0)
    assert seen(any_renderer, plane(0.5), cam, radius=1.0, near=near).min() > 0.995


def test_patches_keep_the_area_of_what_they_stand_for() -> None:
    """Of a quad, less a tenth at most, where pieces of two cells lie in one; and of two back to back, which are one."""
    scene = Scene([FLOOR])
    (rows,) = balls.ball_elements(scene, 1.0)
    assert math.pi * float((rows[:, 3] ** 2).sum()) == pytest.approx(1600, rel=0.1) and (rows[:, 4:] == (0, 1, 0)).all()
    behind = dataclasses.replace(FLOOR, triangles=FLOOR.triangles[:, ::-1].copy())
    (both,) = balls.ball_elements(Scene([FLOOR, behind]), 1.0)
    assert len(both) == len(rows) and math.pi * float((both[:, 3] ** 2).sum()) == pytest.approx(1600, rel=0.1)


def test_patches_of_huge_scenes_are_wider(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(balls, "MOST_PIECES", 2000)
    (rows,) = balls.ball_elements(Scene([quad((0, 0, 0), (1e5, 0, 0), (0, 0, -1e5))]), 0.01)
    assert 200 < len(rows) < 2000


def test_the_estimated_fill_is_what_is_drawn(renderer: ao.Renderer) -> None:
    """Within a quarter, of surfaces and of spheres."""
    atoms = ao.Spheres.from_points(np.random.default_rng(1).random((200, 3)), 0.1)
    scene, size, radius = Scene(default_scene().meshes, spheres=[atoms]), (96, 72), 0.3
    camera = default_scene().cameras[0]
    (splats,) = add_elements(dataclasses.replace(ao.method("spheres"), radius=radius), 1)
    counted = dataclasses.replace(splats.draw, shaders=("sphere_splats.vert", "tests.gl.shaders:every.frag"))
    plan = compile([gbuffer((1, 1, 1), geometric=True), dataclasses.replace(splats, draw=counted)], size, [HIDDEN])
    with renderer.ctx.current():
        buffers = SceneBuffers(renderer._resources, scene)
        executor = FrameExecutor(renderer._resources, plan)
        drawn = float(executor.run(camera.view(size), scene=SceneView(buffers, camera), checked=True).read(HIDDEN).sum())
        executor.release()
        buffers.release()
    _, estimate = balls.ball_fill(scene, camera, camera.view(size), size, radius, 0.3 * radius)
    assert 0.75 < estimate / drawn < 1.25


def test_a_fill_of_minutes_is_refused_with_figures(any_renderer: ao.Renderer) -> None:
    with pytest.raises(ao.SettingsError, match=r"spheres: 1 spheres would fill about \d+ million fragments in 64x48 texels"):
        seen(any_renderer, Scene(spheres=[ao.Spheres.from_points([(0, 0, 0)], 0.3)]), max_fill=1e-6)


def test_depth_buffers_are_refused(any_renderer: ao.Renderer) -> None:
    with pytest.raises(ao.SettingsError, match="spheres: needs a scene"):
        any_renderer.apply(np.ones((8, 8), np.float32), DOWN, settings=settings())


def test_a_driver_that_adds_up_no_floats_is_told_what_to_use(
    any_renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Context, "blends_floats", property(lambda self: False))
    with pytest.raises(ContextError, match=r"use half floats \(the method's sums=half\)"):
        seen(any_renderer, over_floor(0.5, 0.2))
    assert seen(any_renderer, over_floor(0.5, 0.2), sums="half").min() < 0.99
