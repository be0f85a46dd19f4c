"""Materials, and their textures taken at vertices."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssao_gl.errors import SceneError
from ssao_gl.scene.material import ColorTexture, Material, colors_at_vertices
from ssao_gl.scene.model import Mesh

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
T = np.array([[0, 1, 2]], np.uint32)
RAMP = np.arange(12, dtype=np.uint8).reshape(1, 4, 3)


def test_colour_and_material_are_one() -> None:
    """A mesh without a material keeps its colour, also a new one."""
    plain = dataclasses.replace(Mesh(P, T, color=(0.5, 1, 0)), color=(1, 0, 0))
    assert plain.color == (1, 0, 0) and plain.material is None
    assert Mesh(P, T, material=Material((0.2140411, 1, 0, 1))).color == pytest.approx((0.5, 1, 0), abs=1e-6)


@pytest.mark.parametrize(
    ("wrap", "u", "column"),
    [("repeat", 1.0, 3), ("repeat", 5 / 3, 1), ("clamp", 1.7, 3), ("mirror", 4 / 3, 2), ("clamp", -9, 0)],
)
def test_wrapping(wrap: str, u: float, column: int) -> None:
    texture = ColorTexture(RAMP, (wrap, "clamp"))  # type: ignore[arg-type]
    mesh = Mesh(P, T, uv=np.full((3, 2), u, np.float32), material=Material(base_color_texture=texture))
    _, found = colors_at_vertices(mesh)
    assert found is not None and found[0, :3].tolist() == RAMP[0, column].tolist()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(SceneError, match="uint8 of shape"):
        ColorTexture(np.zeros((2, 2), np.uint8))
    with pytest.raises(SceneError, match="repeat, mirror or clamp"):
        ColorTexture(RAMP, ("border", "repeat"))  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="four numbers from 0 to 1"):
        Material((2, 0, 0, 1))
    with pytest.raises(SceneError, match="OPAQUE, MASK or BLEND"):
        Material(alpha_mode="CUT")  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"uv must be \(3, 2\)"):
        Mesh(P, T, uv=np.zeros((4, 2), np.float32))
