"""Materials, and what alpha cuts out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssao_gl.errors import SceneError
from ssao_gl.scene.material import ColorTexture, Material
from ssao_gl.scene.model import Mesh, Scene

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
T = np.array([[0, 1, 2]], np.uint32)
RAMP = np.arange(12, dtype=np.uint8).reshape(1, 4, 3)


def test_colour_and_material_are_one() -> None:
    """A mesh without a material keeps its colour, also a new one."""
    plain = dataclasses.replace(Mesh(P, T, color=(0.5, 1, 0)), color=(1, 0, 0))
    assert plain.color == (1, 0, 0) and plain.material is None
    assert Mesh(P, T, material=Material((0.2140411, 1, 0, 1))).color == pytest.approx((0.5, 1, 0), abs=1e-6)


def leaf(alpha: int, mode: str, cutoff: float = 0.5, factor: float = 1.0) -> Mesh:
    texture = ColorTexture(np.array([[[0, 255, 0, 255], [0, 255, 0, alpha]]], np.uint8))
    material = Material((1, 1, 1, factor), texture, mode, cutoff)  # type: ignore[arg-type]
    return Mesh(P, T, uv=np.zeros((3, 2), np.float32), material=material)


def test_alpha_is_looked_at_only_where_it_decides() -> None:
    """Modes of glTF 2.0, 3.9.4; what would be blended is cut at one half."""
    assert leaf(0, "OPAQUE").cutoff is None and leaf(255, "MASK").cutoff is None and leaf(200, "MASK").cutoff is None
    assert leaf(0, "MASK", 0.3).cutoff == 0.3 and leaf(0, "BLEND", 0.3).cutoff == 0.5
    assert dataclasses.replace(leaf(0, "MASK"), uv=None).cutoff is None
    colors = np.full((3, 4), 255, np.uint8)
    colors[1, 3] = 90
    assert dataclasses.replace(leaf(255, "MASK"), vertex_colors=colors).cutoff == 0.5
    assert Mesh(P, T, vertex_colors=colors).cutoff is None


def test_what_is_cut_out_as_a_whole_shows_nothing_and_widens_nothing() -> None:
    glass = leaf(255, "BLEND", factor=0.4)
    away = dataclasses.replace(glass, transforms=np.diag([9.0, 9, 9, 1])[None])
    assert not glass.can_show and leaf(255, "BLEND", factor=0.6).can_show and leaf(0, "MASK").can_show
    scene = Scene([Mesh(P, T), away])
    assert list(scene.drawn) == scene.meshes[:1] and scene.triangles == 1
    np.testing.assert_array_equal(scene.bounds, Mesh(P, T).bounds)
    np.testing.assert_array_equal(Scene([away]).bounds, away.bounds)


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
