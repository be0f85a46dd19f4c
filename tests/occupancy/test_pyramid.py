"""Larger voxels against sums over all that they hold."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.occupancy.grid import LEVELS, affordable_side, grid_over
from ssao_gl.occupancy.pyramid import atlas, level_starts, pyramid


def brute(clear: np.ndarray, axis: int) -> np.ndarray:
    """Transmittance along an axis over blocks of 2 x 2 x 2: product along it, mean across it."""
    z, y, x = (n // 2 for n in clear.shape)
    blocks = clear.reshape(z, 2, y, 2, x, 2)
    along = blocks.prod(2 * axis + 1)
    across = [k for k in (0, 1, 2) if k != axis]
    kept = [2 * k + 1 - (2 * k + 1 > 2 * axis + 1) for k in across]
    return along.mean(tuple(kept))


def test_every_level_is_what_the_one_below_adds_up_to() -> None:
    finest = np.random.default_rng(1).integers(0, 256, (16, 24, 32)).astype(np.uint8)
    finest[:, :8] = 0
    levels = pyramid(finest)
    assert len(levels) == LEVELS
    below = [finest] * 3
    for level in levels:
        for channel, axis in enumerate((2, 1, 0)):
            exact = 1 - brute(1 - below[channel] / 255, axis)
            assert np.abs(level[..., channel] / 255 - exact).max() <= 0.5 / 255 + 1e-9
        below = [level[..., channel] for channel in range(3)]


def test_half_a_voxel_of_wall_hides_all_from_the_front_and_half_from_the_side() -> None:
    wall = np.zeros((8, 8, 8), np.uint8)
    wall[:, :, 0] = 255
    assert pyramid(wall)[0][0, 0, 0].tolist() == [255, 127, 127]


@pytest.mark.parametrize("shape", [(8, 8, 8), (40, 16, 24)])
def test_levels_lie_side_by_side_in_their_texture(shape: tuple[int, int, int]) -> None:
    levels = pyramid(np.random.default_rng(2).integers(0, 256, shape[::-1]).astype(np.uint8))
    packed = atlas(levels)
    for (x, y, z), level in zip(level_starts(shape)[1:], levels, strict=True):
        d, h, w = level.shape[:3]
        assert np.array_equal(packed[z : z + d, y : y + h, x : x + w, :3], level)


def test_grids_hold_their_box_with_an_empty_voxel_of_the_coarsest_around() -> None:
    bounds = np.array([[-3.3, 0.2, 100.0], [1.1, 0.2, 108.0]])
    grid = grid_over(bounds, 0.5)
    first, end = bounds @ grid.to_voxels[:3, :3].T + grid.to_voxels[:3, 3]
    assert (first >= 2**LEVELS).all() and (end <= np.array(grid.shape) - 2**LEVELS).all()
    assert all(n % 2**LEVELS == 0 for n in grid.shape)
    moved = grid_over(bounds + 40, 0.5)
    assert np.allclose(moved.low, grid.low + 40) and np.allclose(grid_over(bounds + [[-9], [9]], 0.5).low % 4, grid.low % 4)


def test_voxels_are_as_large_as_memory_asks_for() -> None:
    bounds = np.array([[0.0, 0, 0], [100, 50, 20]])
    assert affordable_side(bounds, 1.0) == 1.0
    side = affordable_side(bounds, 0.01, most=1 << 20)
    assert np.prod(grid_over(bounds, side).shape) <= 1 << 20 < np.prod(grid_over(bounds, 0.9 * side).shape)
