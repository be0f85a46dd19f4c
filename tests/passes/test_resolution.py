"""Tests of ``passes/resolution.py``: visibility of a smaller image at full size, against the formula."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.graph.names import DEPTH, NORMAL, NORMAL_SMALL, VISIBILITY, VISIBILITY_RAW
from ssao_gl.passes.resolution import upsample
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..conftest import openable
from ..shapes import quad
from .noise import AWAY, LENSES, SMALL, ball, decoded, noise_through, points, tolerance, unpacked, visibility

TOLERANCE = 0.35


def upsampled(seen: dict[str, np.ndarray], cam: Camera, scale: int) -> tuple[np.ndarray, np.ndarray]:
    """Visibility by the four nearest texels: bilinear weights, times the fit to the tangent plane, times the likeness of normals.

    And the sum of the weights. Where that is next to nothing, the texel that is least off the plane stands in.
    """
    raw, small_z = unpacked(seen[VISIBILITY_RAW][..., 0])
    z = seen[DEPTH][..., 0].astype(np.float64)
    n = decoded(seen[NORMAL])
    here, there, size = points(z, cam, 1), points(small_z, cam, scale), tolerance(z, cam, TOLERANCE, scale)
    y, x = np.mgrid[: z.shape[0], : z.shape[1]]
    corner_x, corner_y, fx, fy = x // scale, y // scale, x % scale / scale, y % scale / scale
    total, norm = np.zeros_like(z), np.zeros_like(z)
    nearest, least = np.ones_like(z), np.full_like(z, 2e30)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        j, i = np.minimum(corner_y + dy, raw.shape[0] - 1), np.minimum(corner_x + dx, raw.shape[1] - 1)
        off = np.where(small_z[j, i] > 0, np.abs((n * (there[j, i] - here)).sum(-1)) / size, 2e30)
        turn = (seen[NORMAL_SMALL][j, i, :2].astype(np.float64) - seen[NORMAL][..., :2]) ** 2
        weight = np.clip(2 - off, 0, 1) * np.clip(1.5 - 4 * turn.sum(-1), 0, 1)
        weight *= (fx if dx else 1 - fx) * (fy if dy else 1 - fy)
        total, norm = total + weight * raw[j, i], norm + weight
        nearest, least = np.where(off < least, raw[j, i], nearest), np.minimum(off, least)
    return np.where(norm > 0.02, total / np.maximum(norm, 1e-9), nearest), norm


@pytest.mark.gl
@pytest.mark.parametrize("scale", [2, 4])
@pytest.mark.parametrize("lens", LENSES)
def test_upsampling_is_its_formula(lens: str, scale: int) -> None:
    """On a ball, whose texels lie off the tangent plane by more and less than the tolerance, and before a wall far behind it."""
    wall = quad((0, 0, -2 * AWAY), (200, 0, 0), (0, 200, 0))
    scene, cam = Scene([*ball(lens).meshes, wall]), LENSES[lens]
    step = upsample(VISIBILITY_RAW, scale, TOLERANCE, None, 0.0)
    seen = noise_through(openable()[0], [step], [VISIBILITY], scene, cam, scale)
    expected, norm = upsampled(seen, cam, scale)
    off = np.abs(visibility(seen[VISIBILITY]) - expected)
    off[np.abs(norm - 0.02) < 1e-3] = 0  # either way is right
    off[-scale:] = off[:, -scale:] = 0  # beyond the border the last texels stand for others
    assert (norm < 0.9).sum() > 0.02 * norm.size < (norm > 0.99).sum(), "some fit and some do not"
    assert off.max() <= 1.01 / 255
    assert SMALL[0] % scale == SMALL[1] % scale == 0
