"""Textures sampled on the CPU: texels, blending between them, wrapping, alpha of meshes."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.scene.material import ColorTexture, Material
from ssao_gl.scene.model import Mesh
from ssao_gl.scene.texels import alpha_at, texels_at

RAMP = np.repeat(np.arange(0, 160, 40, dtype=np.uint8)[None, :, None], 3, 2)
"""0, 40, 80, 120 from left to right."""


@pytest.mark.parametrize(
    ("wrap", "nearest", "u", "value"),
    [
        ("repeat", True, 0.3, 40), ("repeat", False, 0.375, 40), ("repeat", False, 0.5, 60), ("repeat", False, 0.0, 60),
        ("clamp", False, 0.0, 0), ("clamp", False, 7.0, 120), ("clamp", True, -7.0, 0), ("mirror", False, 1.0, 120),
        ("mirror", True, 1.3, 80), ("mirror", True, -0.3, 40), ("repeat", True, -0.3, 80), ("repeat", True, 1.3, 40),
    ],
)  # fmt: skip
def test_a_texel_and_what_is_between_two(wrap: str, nearest: bool, u: float, value: float) -> None:
    texture = ColorTexture(RAMP, (wrap, "clamp"), nearest)  # type: ignore[arg-type]
    found = texels_at(texture, np.array([[u, 0.5]]))[0] * 255
    np.testing.assert_allclose(found, [value, value, value, 255], atol=1e-9)


def test_alpha_of_a_triangle_is_a_product() -> None:
    texels = np.full((1, 2, 4), 255, np.uint8)
    texels[0, 0, 3] = 51
    material = Material((1, 1, 1, 0.5), ColorTexture(texels, nearest=True), "MASK")
    colors = np.full((3, 4), 255, np.uint8)
    colors[2, 3] = 0
    mesh = Mesh(
        np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32), vertex_colors=colors,
        uv=np.array([[0, 0], [1, 0], [0, 0]], np.float32), material=material,
    )  # fmt: skip
    u, v = np.array([0.0, 0.75, 0.0]), np.array([0.0, 0.0, 0.5])
    np.testing.assert_allclose(alpha_at(mesh, np.zeros(3, int), u, v), [0.1, 0.5, 0.05])
