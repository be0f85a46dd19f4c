"""Points of the unit ball and the planes that reflect them. No OpenGL."""

import numpy as np
import pytest

from ssao_gl.sampling.sphere import reflection_planes, sphere_points


@pytest.mark.parametrize("count", [1, 2, 5, 8, 16, 31, 128])
def test_points_lie_in_the_unit_ball(count: int) -> None:
    points = sphere_points(count)
    assert points.shape == (count, 3) and points.dtype == np.float32
    length = np.linalg.norm(points, axis=1)
    assert length.min() > 0 and length.max() < 1
    np.testing.assert_array_equal(points, sphere_points(count))


def test_points_are_spread_evenly_in_volume() -> None:
    points = sphere_points(128).astype(np.float64)
    assert np.abs(points.mean(0)).max() < 0.03
    np.testing.assert_allclose(points.T @ points / 128, np.eye(3) / 5, atol=0.03)  # of the solid ball
    shells = np.histogram((points**2).sum(1) ** 1.5, bins=8, range=(0, 1))[0]  # of equal volume
    np.testing.assert_array_equal(shells, 16)


@pytest.mark.parametrize("tile", [1, 2, 4, 8])
def test_planes_are_unit_normals_over_half_the_sphere(tile: int) -> None:
    normals = reflection_planes(tile)
    assert normals.shape == (tile, tile, 4) and normals.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-6)
    assert (normals[..., 2] > 0).all() and (normals[..., 3] == 0).all()
    assert len(np.unique(normals.reshape(-1, 4), axis=0)) == tile * tile
