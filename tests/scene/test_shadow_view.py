"""The view of a light: all that a camera sees is in its map, and all that casts."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.scene.bounds import box_corners
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import CropLens
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.shadow_view import shadow_camera

BOX = np.array([[-3.0, 0, -1], [5, 2, 4]])
SIZE = (64, 48)


def in_map(camera: Camera, points: np.ndarray) -> np.ndarray:
    local = (points - camera.pose[:3, 3]) @ camera.pose[:3, :3]
    clip = np.column_stack([local, np.ones(len(local))]) @ camera.view((256, 256)).projection.T
    return clip[:, :3] / clip[:, 3:]


@pytest.mark.parametrize("to_light", [(0, 1, 0), (0.6, 0.8, 0), (-0.36, 0.48, 0.8)])
@pytest.mark.parametrize("far_away", [0.0, 1e6])
def test_the_map_holds_all_that_is_seen(to_light: tuple[float, float, float], far_away: float) -> None:
    light, offset = np.asarray(to_light, float), np.full(3, far_away)
    eye = Camera.perspective(0.6, 0.1, None, look_at(np.array((2.0, 1.5, 6.0)) + offset, np.array((0, 1, 0)) + offset))
    sun = shadow_camera(light, BOX + offset, eye, SIZE, 256)
    points = np.random.default_rng(0).uniform(*BOX, (4000, 3)) + offset
    local = (points - eye.pose[:3, 3]) @ eye.pose[:3, :3]
    clip = np.column_stack([local, np.ones(len(local))]) @ eye.view(SIZE).projection.T
    seen = (np.abs(clip[:, :2]) <= clip[:, 3:]).all(1) & (-local[:, 2] > 0.1)
    assert seen.sum() > 100
    found = in_map(sun, points)
    assert np.abs(found[seen, :2]).max() <= 1.0
    assert np.abs(in_map(sun, box_corners(*BOX) + offset)[:, 2]).max() < 1  # nothing that casts is cut off
    whole = shadow_camera(light, BOX + offset, Camera.orthographic(40, 0.1, 100, eye.pose), SIZE, 256)
    assert np.linalg.det(sun.view((256, 256)).projection[:2, :2]) > np.linalg.det(whole.view((256, 256)).projection[:2, :2])


def test_tiles_have_the_map_of_the_whole() -> None:
    eye = Camera.perspective(0.6, 0.1, None, look_at((2, 1.5, 6), (0, 1, 0)))
    tile = Camera(CropLens(eye.lens, SIZE, (10, 20)), eye.pose)
    one, other = (shadow_camera(np.array([0.6, 0.8, 0]), BOX, c, s, 256) for c, s in ((eye, SIZE), (tile, (16, 16))))
    np.testing.assert_array_equal(one.view((256, 256)).projection, other.view((256, 256)).projection)
    np.testing.assert_array_equal(one.pose, other.pose)


def test_a_box_that_is_not_seen_and_one_without_extent() -> None:
    away = Camera.perspective(0.6, 0.1, None, look_at((0, 0, 50), (0, 0, 100)))
    point = np.zeros((2, 3))
    for box in (BOX, point):
        assert np.isfinite(shadow_camera(np.array([0.0, 1, 0]), box, away, SIZE, 64).view((64, 64)).projection).all()
