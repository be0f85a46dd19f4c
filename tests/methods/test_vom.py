"""Vicinity occlusion maps against closed forms: planes, the corner of two walls, a step."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..shapes import camera, corner, plane, quad

SIZE = (481, 360)


def settings(radius: float = 0.8, blur: Any = None, **changes: Any) -> ao.Settings:
    return ao.Settings(method=dataclasses.replace(ao.method("vom"), radius=radius, **changes), blur=blur)


def seen(renderer: ao.Renderer, scene: Scene, cam: Camera, **changes: Any) -> np.ndarray:
    return renderer.render(scene, cam, SIZE, settings(**changes), aovs=("visibility",), checked=True).visibility


def off_centre(cam: Camera) -> Camera:
    matrix = cam.lens.matrix(SIZE).copy()
    matrix[0] += 0.4 * matrix[3]
    return Camera.from_matrix(matrix, cam.pose)


LENSES = {"perspective": camera(), "off-centre": off_centre(camera()), "parallel": Camera.orthographic(4.0, 0.0, 60.0)}


@pytest.mark.parametrize("tilt", np.linspace(-1.45, 1.45, 13))
@pytest.mark.parametrize("lens", LENSES)
def test_tilted_planes_are_open(any_renderer: ao.Renderer, lens: str, tilt: float) -> None:
    """To the last bit, to the very border, and where the plane ends before background."""
    assert seen(any_renderer, plane(tilt), LENSES[lens]).min() == 1


@pytest.mark.parametrize("scale", [1, 2, 4, 8])
def test_the_corner_of_two_walls_is_half_occluded(any_renderer: ao.Renderer, scale: int) -> None:
    visibility = seen(any_renderer, corner(), camera(), scale=scale, max_radius=100)
    assert visibility[150:210, 240].mean() == pytest.approx(0.5, abs=0.05)


def test_walls_darken_towards_their_corner_as_they_do(any_renderer: ao.Renderer) -> None:
    """Against what a wall takes from a point at the distance u of the radius: (acos u - u sqrt(1 - u^2)) / pi."""
    visibility = seen(any_renderer, corner(), camera())[180]
    z = any_renderer.render(corner(), camera(), SIZE, settings(), aovs=("depth",)).depth[180]
    u = np.abs(camera().view(SIZE).points(np.broadcast_to(z, SIZE[::-1]))[180, :, 0]) * math.sqrt(2) / 0.8
    near = np.minimum(u, 1)
    exact = 1 - (np.arccos(near) - near * np.sqrt(1 - near**2)) / math.pi
    assert np.abs(visibility - exact).max() < 0.12 and np.abs(visibility - exact).mean() < 0.03
    assert (visibility[u > 1.6] == 1).all()


def test_a_step_darkens_its_foot_alone(any_renderer: ao.Renderer) -> None:
    """A box on a wall, seen from the front: its face is open up to its edges, and the wall far from it."""
    step = Scene([quad((0, 0, -5), (20, 0, 0), (0, 20, 0)), quad((-10, 0, -4.5), (10, 0, 0), (0, 20, 0))])
    row = seen(any_renderer, step, camera())[180]
    edge = SIZE[0] // 2
    assert (row[: edge - 1] == 1).all() and (row[edge + 100 :] == 1).all()
    assert row[edge + 8 : edge + 16].mean() < 0.85


def test_there_is_no_noise_to_filter(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """The default filter has nothing to do, and is left out; one with a width of its own is drawn."""
    default, wide = (plan_render(settings(blur=blur), (640, 360)) for blur in (ao.Joint(), ao.Joint(radius=3)))
    assert not any(step.task.role == "denoise" for step in default.steps)
    assert default.culled["blur"] == "vom has no noise"
    assert sum(step.task.role == "denoise" for step in wide.steps) == 2
    size = (192, 144)
    pictures = [
        any_renderer.render(embedded, None, size, settings(blur=blur), aovs=("visibility",)).visibility
        for blur in (None, ao.Joint(), ao.Joint(radius=3))
    ]
    assert (pictures[0] == pictures[1]).all()
    assert 0 < np.abs(pictures[0] - pictures[2]).mean() < 0.06


def test_arrays_are_as_dark_as_scenes(any_renderer: ao.Renderer, embedded: Scene) -> None:
    cam, size = embedded.cameras[0], (320, 240)
    drawn = any_renderer.render(embedded, cam, size, settings(), aovs=("visibility", "depth"))
    applied = any_renderer.apply(drawn.depth, cam, settings=settings())
    off = np.abs(drawn.visibility - applied.visibility)
    assert off.mean() < 0.01  # normals are rebuilt from depth
