"""Rays through volumes: against closed forms, against triangles in Embree, and against what the G-buffer shows."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.truth import Tracing, surface, trace
from ssao_gl.truth.rays import RayScene
from ssao_gl.truth.store import content_key

from ..shapes import quad
from ..volumes import ball, slab

SIZE = (64, 48)
FLOOR = quad((0, 0, 0), (20, 0, 0), (0, 0, -20))


def bumpy(n: int = 24) -> ao.Volume:
    """Noise, smoothed once: surfaces of every curvature."""
    values = np.random.default_rng(3).normal(size=(n, n + 2, n - 3))
    for axis in range(3):
        values = values + np.roll(values, 1, axis) + np.roll(values, -1, axis)
    affine = np.array([[0.9, 0.1, 0, -9], [0, 1.2, 0.2, 4], [-0.1, 0, 1, 2], [0, 0, 0, 1]])
    return ao.Volume(values, affine, iso=float(np.quantile(values, 0.7)))


def test_a_ball_above_a_floor_occludes_as_on_paper() -> None:
    """A ball of radius r at height h over a point takes (r / h)^2 cos of its light, as long as it stays above the horizon."""
    scene = Scene([FLOOR], volumes=[ball(0.5, 64, (0, 1.2, 0))])
    cam = Camera.perspective(0.9, 0.1, 50.0, look_at((0, 4, 6), (0, 0, 0)))
    seen = surface(scene, cam, SIZE)
    truth = trace(scene, cam, SIZE, Tracing(radius=20.0, spp=256))
    points = seen.points()
    floor = (np.abs(points[:, 1]) < 1e-3) & (np.hypot(points[:, 0], points[:, 2]) < 4)
    away = np.array([0, 1.2, 0]) - points[floor]
    d = np.linalg.norm(away, axis=1)
    above = away[:, 1] / d > 0.5 / d
    expected = 1 - (0.5 / d) ** 2 * away[:, 1] / d
    error = truth.visibility[truth.covered][floor] - expected
    assert above.all() and floor.sum() > 500
    assert abs(error.mean()) < 1e-3 and np.sqrt((error**2).mean()) < 0.015


def test_a_convex_surface_is_open() -> None:
    scene = ao.as_scene(ball())
    truth = trace(scene, scene.default_camera(SIZE), SIZE, Tracing(radius=1.0, spp=64))
    assert truth.visibility.min() == 1 and truth.covered.sum() > 400


@pytest.mark.parametrize("make", [bumpy, lambda: ball(1.0, 24, (2e5, 0, -1e5))], ids=["bumpy", "far ball"])
def test_rays_see_what_the_g_buffer_shows(any_renderer: ao.Renderer, make: Any) -> None:
    scene = ao.as_scene(make())
    cam = scene.default_camera(SIZE)
    picture = any_renderer.render(scene, cam, SIZE, aovs=("depth", "normal"), checked=True)
    seen = surface(scene, cam, SIZE)
    both = seen.covered & (picture.depth > 0)
    assert (seen.covered != (picture.depth > 0)).mean() < 1e-3 and both.sum() > 400
    assert np.quantile(np.abs(seen.depth - picture.depth)[both], 0.99) < 1e-5 * seen.depth.max()
    shading = (seen.shading @ cam.pose[:3, :3])[both[seen.covered]]
    assert np.quantile((shading * picture.normal[both]).sum(1), 0.02) > np.cos(np.radians(0.5))


def test_the_rays_agree_with_marching_cubes_of_a_finer_field() -> None:
    """Sampled eight times as finely, triangles of marching cubes are the trilinear surface: the independent check."""
    measure = pytest.importorskip("skimage.measure")
    volume = bumpy(12)
    finer = 8
    steps = [np.linspace(0, n - 1, (n - 1) * finer + 1) for n in volume.field.shape]
    from scipy.interpolate import RegularGridInterpolator

    field = RegularGridInterpolator([np.arange(n) for n in volume.field.shape], volume.field.astype(np.float64))
    values = field(np.stack(np.meshgrid(*steps, indexing="ij"), -1))
    corners, faces, _, _ = measure.marching_cubes(values, 0.0)
    placed = corners[:, ::-1] / finer @ volume.to_world[:3, :3].T + volume.to_world[:3, 3]
    mesh = Scene([Mesh(placed.astype(np.float32), faces.astype(np.uint32))])
    scene, tracing = ao.as_scene(volume), Tracing(radius=2.5, spp=64)
    cam = scene.default_camera((48, 36))
    ours, theirs = (trace(one, cam, (48, 36), tracing) for one in (scene, mesh))
    both = ours.covered & theirs.covered
    assert (ours.covered != theirs.covered).mean() < 0.01 and both.sum() > 250
    assert np.median(np.abs(ours.depth - theirs.depth)[both]) < 0.005
    difference = (ours.visibility - theirs.visibility)[both]
    assert abs(difference.mean()) < 0.005 and ours.visibility[both].mean() < 0.95


@pytest.mark.parametrize("opacity", [0.2, 0.7, 1.0])
def test_opacity_along_a_ray_counts(opacity: float) -> None:
    """A slab of 4 voxels takes 1 - (1 - a)^(4 / unit) of a ray across it, and more of one that is aslant."""
    volume = slab(opacity, thickness=4, n=24, unit=2.0)
    rays = RayScene(Scene(volumes=[volume]))
    slant = np.array([[0, 0, -1], [0.6, 0, -0.8], [0, 0, 1]], np.float32)
    start = np.tile(((np.array([0, 0, 9.0]) - rays.center) * rays.scale).astype(np.float32), (3, 1))
    taken = rays.occluded(start, slant, 4.0)
    expected = 1 - (1 - opacity) ** (4 / 2 / np.array([1, 0.8]))
    np.testing.assert_allclose(taken[:2], expected, atol=0.02)
    assert taken[2] == 0


def test_a_translucent_plane_does_not_shade_itself() -> None:
    volume = slab(0.5, thickness=12, n=24)
    cam = Camera.perspective(0.4, 0.1, 90.0, look_at((3, 4, 30), (0, 0, 6)))
    truth = trace(ao.as_scene(volume), cam, (32, 24), Tracing(radius=5.0, spp=64))
    assert truth.covered.any() and truth.visibility[truth.covered].min() > 0.999


def test_everything_else_is_a_blocker_too() -> None:
    """A translucent slab before a wall: the share of light that is left is a product."""
    scene = Scene([quad((0, 0, -9), (4, 0, 0), (0, 4, 0))], volumes=[slab(0.5, thickness=4, n=24)])
    rays = RayScene(scene)
    start = ((np.array([[0, 0, 9.0], [9.0, 0, 9.0]]) - rays.center) * rays.scale).astype(np.float32)
    down = np.array([[0, 0, -1], [0, 0, -1]], np.float32)
    np.testing.assert_allclose(rays.occluded(start, down, 4.0), [1.0, 1 - 0.5**4], atol=0.02)


def test_the_key_of_a_cached_result_knows_what_is_seen() -> None:
    volume, tracing = ball(1.0, 16), Tracing(radius=1.0)
    view = ao.as_scene(volume).default_camera(SIZE)
    louder = dataclasses.replace(volume, array=volume.array * 2)
    seen = [
        volume,
        dataclasses.replace(volume, iso=0.1),
        louder,
        dataclasses.replace(volume, affine=volume.affine * [[2], [2], [2], [1]]),
    ]
    seen += [slab(0.5), slab(0.6), slab(0.5, unit=2.0), slab(0.5, step=1.0)]
    keys = [content_key(Scene(volumes=[one]), view, SIZE, tracing) for one in seen]
    assert len(set(keys)) == len(keys)
    colored = dataclasses.replace(volume, color=(1.0, 0, 0))
    assert content_key(Scene(volumes=[colored]), view, SIZE, tracing) == keys[0]


def test_without_numba_a_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[truth-volumes\]'"):
        RayScene(ao.as_scene(ball(1.0, 16)))
