"""Volumes in the G-buffer: depth and normals against closed forms, under every lens, beside meshes, in tiles, behind each other."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SceneError
from ssao_gl.gl import volume_buffers
from ssao_gl.graph.names import DEPTH, DEPTH_LAYER_2
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.scene.pose import look_at

from ..contract.test_tiles import off_centre
from ..shapes import quad
from ..volumes import ball, half_space, slab

SIZE = (96, 72)
NORMAL = np.array([0.3, -0.5, 0.81]) / np.linalg.norm([0.3, -0.5, 0.81])


def shot(
    renderer: ao.Renderer, scene: Scene | ao.Volume, cam: Camera, aovs: tuple[str, ...] = ("depth", "normal")
) -> ao.Picture:
    return renderer.render(ao.as_scene(scene), cam, SIZE, aovs=aovs, checked=True)


def world(picture: ao.Picture, cam: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals (n, 3) of what is seen."""
    seen = picture.depth > 0
    points = cam.view(SIZE).points(picture.depth.astype(np.float64))[seen]
    return points @ cam.pose[:3, :3].T + cam.pose[:3, 3], picture.normal[seen] @ cam.pose[:3, :3].T


def lenses(pose: np.ndarray, scale: float = 1.0) -> list[Camera]:
    seen = Camera.perspective(0.8, 0.1 * scale, 100 * scale, pose)
    return [seen, off_centre(seen, SIZE), Camera.orthographic(6 * scale, 0.0, 100 * scale, pose)]


@pytest.mark.parametrize("place", [(0, 0, 0), (2e5, -1e5, 3e5)], ids=["near 0", "far from 0"])
def test_a_ball_is_where_it_should_be(renderer: ao.Renderer, place: tuple[float, float, float]) -> None:
    volume = ball(1.0, 48, place)
    for cam in lenses(look_at(np.array(place) + [2, 1.5, 3], place)):
        picture = shot(renderer, volume, cam)
        points, normals = world(picture, cam)
        away = points - place
        assert len(points) > 400
        # Between voxels the field is trilinear: off by h^2 / 8 of its second derivatives, 1 / R along two directions.
        assert np.abs(np.linalg.norm(away, axis=1) - 1).max() < 1.01 * volume.voxel**2 / 4
        unit = away / np.linalg.norm(away, axis=1, keepdims=True)
        assert (unit * normals).sum(1).min() > np.cos(np.radians(0.5))


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6])
@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_a_plane_is_met_exactly_whatever_the_affine(renderer: ao.Renderer, scale: float, mirrored: float) -> None:
    affine = np.array([[1.0, 0.4, 0.1, 3], [-0.3, 0.8, 0.2, -2], [0.2, 0.1, 1.3, 1], [0, 0, 0, 1]])
    affine[:3, 0] *= mirrored
    affine[:3] *= scale
    middle = affine[:3, :3] @ [4, 3.5, 4.5] + affine[:3, 3]
    volume = half_space(affine, NORMAL, middle)
    for cam in lenses(look_at(middle + 3 * scale * NORMAL, middle, (0.1, 1, 0)), scale):
        points, normals = world(shot(renderer, volume, cam), cam)
        index = (points - affine[:3, 3]) @ np.linalg.inv(affine[:3, :3]).T
        inner = ((index > 1) & (index < np.array(volume.array.shape) - 2)).all(1)  # away from the caps
        assert inner.sum() > 50
        assert np.abs((points - middle) @ NORMAL)[inner].max() < 1e-5 * scale
        assert (normals @ NORMAL)[inner].min() > 1 - 1e-5


def test_an_eye_inside_sees_the_surface_from_within(renderer: ao.Renderer) -> None:
    cam = Camera.perspective(1.2, 1e-3, None, look_at((0.2, 0.1, 0), (1, 0.3, 0.2)))
    points, normals = world(shot(renderer, ball(1.0, 64), cam), cam)
    assert len(points) == SIZE[0] * SIZE[1]
    assert np.abs(np.linalg.norm(points, axis=1) - 1).max() < 2e-3 and (points * normals).sum(1).max() < -0.99


def test_clip_planes_cut(renderer: ao.Renderer) -> None:
    pose = look_at((0, 0, 4), (0, 0, 0))
    cut = shot(renderer, ball(), Camera.perspective(0.6, 3.5, 9.0, pose))
    assert 4.5 < cut.depth[SIZE[1] // 2, SIZE[0] // 2] < 5.01  # the front is before the near plane: the far side is seen
    gone = shot(renderer, ball(), Camera.perspective(0.6, 0.1, 2.9, pose))
    assert not gone.depth.any()


def test_a_volume_and_a_mesh_hide_each_other(renderer: ao.Renderer) -> None:
    cam = Camera.perspective(0.6, 0.1, 20.0, look_at((0, 0, 5), (0, 0, 0)))
    wall = quad((0.5, 0, 0.2), (0.5, 0, 0), (0, 2, 0))
    both = shot(renderer, Scene([wall], volumes=[ball()]), cam).depth
    alone = [shot(renderer, scene, cam).depth for scene in (Scene([wall]), Scene(volumes=[ball()]))]
    far = [np.where(one > 0, one, np.inf) for one in alone]
    nearest = np.where(np.isfinite(np.minimum(*far)), np.minimum(*far), 0)
    differ = np.abs(both - nearest) > 1e-4
    assert differ.mean() < 2e-3 and (far[0] < far[1]).sum() > 100 and (far[1] < far[0]).sum() > 100


@pytest.mark.parametrize("make", [lambda: ball(), lambda: slab(0.9)], ids=["iso", "transfer"])
def test_tiles_are_the_whole(any_renderer: ao.Renderer, make: object) -> None:
    scene = ao.as_scene(make())  # type: ignore[operator]
    cam = scene.default_camera(SIZE)
    from ssao_gl.scene.lens import CropLens

    whole = shot(any_renderer, scene, cam)
    for corner in ((0, 0), (48, 0), (16, 24)):
        tile = dataclasses.replace(cam, lens=CropLens(cam.lens, SIZE, corner))
        part = any_renderer.render(scene, tile, (48, 48), aovs=("depth", "normal"), checked=True)
        rows = slice(SIZE[1] - corner[1] - 48, SIZE[1] - corner[1])
        same = whole.depth[rows, corner[0] : corner[0] + 48]
        assert ((part.depth > 0) != (same > 0)).mean() < 2e-3
        both = (part.depth > 0) & (same > 0)
        assert np.abs(part.depth - same)[both].max() < 1e-5 * same.max()


def test_the_second_layer_is_the_far_side(any_renderer: ao.Renderer) -> None:
    cam = Camera.orthographic(2.2, 0.0, 20.0, look_at((0, 0, 5), (0, 0, 0)))
    settings = ao.Settings(method=ao.Bitmask(scale=1, layers=2, radius=0.1, guard=0), blur=None)
    scene = Scene(volumes=[ball()])
    first, second = (any_renderer.resource(scene, cam, SIZE, settings, name) for name in (DEPTH, DEPTH_LAYER_2))
    assert first is not None and second is not None
    seen = (first > 0) & (first < 4.9)
    assert seen.sum() > 500
    np.testing.assert_allclose((first + second)[seen], 10, atol=5e-3)


@pytest.mark.parametrize("opacity", [0.2, 0.6, 0.95])
@pytest.mark.parametrize("step", [0.25, 0.5, 1.0])
def test_half_of_the_light_goes_where_it_should(any_renderer: ao.Renderer, opacity: float, step: float) -> None:
    """In a slab of opacity a, 1 - (1 - a)^x = 1/2 after x unit lengths, whatever the step."""
    volume = slab(opacity, thickness=10, n=24, step=step)
    cam = Camera.orthographic(8.0, 0.0, 60.0, look_at((0, 0, 30), (0, 0, 0)))
    depth = shot(any_renderer, volume, cam).depth
    inside = np.log(0.5) / np.log(1 - opacity)
    # The slab begins where the field is 1/2, within a voxel's blur.
    np.testing.assert_allclose(depth[20:-20, 20:-20], 30 - 5 + inside, atol=0.1 + 0.25 * step)
    color = any_renderer.render(ao.as_scene(volume), cam, SIZE, aovs=("color",)).color[20:-20, 20:-20]
    assert (color == [255, 0, 0]).all()


def test_what_lets_half_of_the_light_through_is_not_there(any_renderer: ao.Renderer) -> None:
    cam = Camera.orthographic(8.0, 0.0, 60.0, look_at((0, 0, 30), (0, 0, 0)))
    assert not shot(any_renderer, slab(0.1, thickness=4), cam).depth.any()


def test_flat_and_tiny_volumes_are_drawn(any_renderer: ao.Renderer) -> None:
    line = np.array([0, 5, 0, 9], np.uint8)
    for shape in ((4, 1, 1), (1, 2, 2), (1, 1, 4)):
        scene = ao.as_scene(ao.Volume(line.reshape(shape), iso=3.0))
        assert 0 < (shot(any_renderer, scene, scene.default_camera(SIZE)).depth > 0).mean() < 1


def test_a_volume_larger_than_the_driver_holds_is_refused_in_a_line(
    any_renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(volume_buffers, "largest_3d_texture", lambda resources: 32)
    scene = ao.as_scene(ball(1.0, 48))
    with pytest.raises(SceneError, match=r"48 x 48 x 48 voxels; .* holds 30 along each side: take every 2\. of them"):
        shot(any_renderer, scene, scene.default_camera(SIZE))
