"""Tests of ``stress/analytic_depth.py``."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.stress.analytic_depth import as_half_floats, ball_depth, cast, flat, room, window_depth
from ssao_gl.stress.reduce import crop
from ssao_gl.stress.shapes import lens
from ssao_gl.stress.shot import Shot


def test_depth_by_rays_is_exact() -> None:
    camera, size = lens(), (32, 24)
    z = cast(camera, size, flat((0, 0, -5), (0, 0.5, 1)))
    points = camera.view(size).points(z)
    np.testing.assert_allclose(points @ [0, 0.5, 1], -5, rtol=1e-12)
    points = camera.view(size).points(cast(camera, size, ball_depth((0, 0, -5), 1.0)))
    seen = points[..., 2] < 0
    assert seen.sum() > 20 and not seen.all()
    np.testing.assert_allclose(np.linalg.norm(points[seen] - [0, 0, -5], axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("camera", [lens(), lens(None), ao.Camera.orthographic(6.0, 0.0, 40.0)])
def test_window_depth_and_back(camera: ao.Camera) -> None:
    z = cast(camera, (16, 12), *room())
    d = window_depth(camera, z, np.float64)
    c = camera.view((16, 12)).depth_constants
    y, x = np.mgrid[:12, :16]
    p = np.stack([(x + 0.5) / 16, 1 - (y + 0.5) / 12, d - c["u_depth_far"], np.ones_like(d)], -1)
    with np.errstate(all="ignore"):
        back = (p @ c["u_depth_num"]) / (p @ c["u_depth_den"])
    np.testing.assert_allclose(np.where(z > 0, back, 0), z, rtol=1e-9)
    assert ((d >= 0) & (d <= 1)).all() and (np.abs(as_half_floats(d, 16) - d) <= 0.5 / 65535 + 1e-12).all()


def test_a_part_of_an_image_shows_the_same_points() -> None:
    camera = ao.Camera.from_matrix(lens().lens.matrix((20, 15)))
    depth = cast(camera, (20, 15), *room())
    shot = crop(Shot(camera, depth=depth), slice(3, 11), slice(5, 18))
    points = shot.camera.view((13, 8)).points(np.asarray(shot.depth))
    np.testing.assert_allclose(points, camera.view((20, 15)).points(depth)[3:11, 5:18], atol=1e-9)
