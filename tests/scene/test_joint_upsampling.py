"""Images brought to the size of a larger colour keep planes, edges and constants."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.scene.joint_upsampling import JointUpsampling
from ssao_gl.stress.analytic_depth import cast, flat

CAMERA = ao.Camera.perspective(0.8)


def test_planes_stay_planes() -> None:
    surface = flat((0, 0, -3), (0.3, 0.4, 1))
    low, high = (cast(CAMERA, size, surface).astype(np.float32) for size in ((40, 30), (160, 120)))
    to = JointUpsampling(low, np.full((120, 160, 3), 90, np.uint8))
    assert np.abs(to.depth - high)[2:-2, 2:-2].max() < 1e-4
    assert np.allclose(to.mean(np.full((30, 40), 0.25)), 0.25, atol=1e-6)
    normal = to.directions(np.broadcast_to(np.float32([0.6, 0, 0.8]), (30, 40, 3)))
    assert np.allclose(normal, [0.6, 0, 0.8], atol=1e-6)


def test_edges_follow_the_colour_and_surfaces_are_not_mixed() -> None:
    """The edge lies at column 50 of 100 colours, which is 12.5 of the texels; beyond it is no surface."""
    depth = np.full((10, 25), 2.0, np.float32)
    depth[:, 12:] = 5.0
    depth[:, 20:] = 0.0
    color = np.full((40, 100, 3), 30, np.uint8)
    color[:, 50:80] = 220
    color[:, 80:] = 120
    to = JointUpsampling(depth, color)
    wanted = np.repeat([2.0, 5.0, 0.0], [50, 30, 20])
    assert np.abs(to.depth - wanted).max() < 1e-5


@pytest.mark.parametrize("size", [(39, 30), (40, 29), (80, 120), (160, 61)])
def test_other_proportions_are_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ao.FormatError, match=f"color is {size[0]}x{size[1]}, depth 40x30"):
        JointUpsampling(np.ones((30, 40), np.float32), np.zeros((*size[::-1], 3), np.uint8))
