"""Blocks of spheres, waves of them, and the depths that hide them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.scene.ball_culling import LEVELS, farthest_depths, in_view, nearest_first
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.sphere_blocks import BLOCK, sphere_blocks

RANDOM = np.random.default_rng(11)


@pytest.mark.parametrize("count", [1, BLOCK, BLOCK + 1, 10 * BLOCK + 7])
def test_blocks_hold_every_sphere_once_in_balls_around_them(count: int) -> None:
    centers, radii = RANDOM.normal(size=(count, 3)), RANDOM.uniform(0, 0.2, count).astype(np.float32)
    blocks = sphere_blocks(centers, radii)
    assert np.array_equal(np.sort(blocks.order), np.arange(count)) and len(blocks.balls) == -(-count // blocks.size)
    for index, ball in enumerate(blocks.balls):
        these = blocks.order[index * blocks.size : (index + 1) * blocks.size]
        assert (np.linalg.norm(centers[these] - ball[:3], axis=1) + radii[these] <= ball[3] * (1 + 1e-12)).all()


def test_blocks_are_compact() -> None:
    centers = RANDOM.uniform(-1, 1, (200 * BLOCK, 3))
    balls = sphere_blocks(centers, np.zeros(len(centers), np.float32)).balls
    assert np.median(balls[:, 3]) < 0.35 and sphere_blocks(np.zeros((5000, 3)), np.ones(5000, np.float32)).balls[0, 3] == 1


def test_what_is_out_of_view_is_left_out_and_no_more() -> None:
    view = Camera.perspective(0.8, 1.0, 20.0, np.eye(4)).view((160, 90))
    balls = np.column_stack([RANDOM.uniform(-30, 30, (4000, 3)), RANDOM.uniform(0.01, 1, 4000)])
    shown = in_view(balls, view, view.projection)
    clip = np.column_stack([balls[:, :3], np.ones(4000)]) @ view.projection.T
    centers_inside = (np.abs(clip[:, :2]) < clip[:, 3:]).all(1) & (-balls[:, 2] > 1) & (-balls[:, 2] < 20)
    assert shown[centers_inside].all() and 0.001 < shown.mean() < 0.3


def test_waves_hold_every_ball_once_the_nearest_of_each_place_first() -> None:
    view = Camera.perspective(0.8, 1.0, 60.0, np.eye(4)).view((160, 90))
    balls = np.column_stack([RANDOM.uniform(-9, 9, (4000, 2)), RANDOM.uniform(-40, -20, 4000), np.full(4000, 0.1)])
    waves = list(nearest_first(balls, view.projection, (160, 90)))
    assert np.array_equal(np.sort(np.concatenate(waves)), np.arange(4000)) and len(waves) > 3
    means = [-balls[wave, 2].mean() for wave in waves]
    assert means == sorted(means) and np.argmax(balls[:, 2]) in waves[0]
    assert list(nearest_first(balls[:0], view.projection, (160, 90))) == []


@given(st.integers(1, 200), st.integers(1, 130), st.integers(0, 2**32 - 1))
def test_each_cell_holds_the_farthest_of_its_pixels(width: int, height: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    depth = random.uniform(1, 9, (height, width)).astype(np.float32) * (random.random((height, width)) < 0.95)
    depths = np.where(depth > 0, depth, np.inf)
    levels = farthest_depths(depth)
    across = levels.shape[1] // 3 * 2
    for level in range(LEVELS + 1):
        side = 1 << level
        row, column = (0, 0) if level == 0 else (levels.shape[0] - (levels.shape[0] >> (level - 1)), across)
        y, x = int(random.integers(height)) // side, int(random.integers(width)) // side
        assert levels[row + y, column + x] == depths[y * side : (y + 1) * side, x * side : (x + 1) * side].max()
