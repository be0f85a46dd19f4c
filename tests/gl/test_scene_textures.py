"""Textures and cut-outs as they are drawn: texels at their places, wrapping, smaller copies, alpha, the same as rays see."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.gl.scene_textures import _fitting
from ssao_gl.render.renderer import Renderer
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.material import ColorTexture, Material
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.srgb import decode, encode
from ssao_gl.scene.texels import texels_at

CAMERA = Camera.orthographic(2, 0.1, 10, look_at((0, 0, 3), (0, 0, 0)))
SIZE = (64, 64)
CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0]], np.float32)
UV = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], np.float32)
FACES = np.array([[0, 1, 2], [1, 3, 2]], np.uint32)
RED, BLUE, GREEN = (255, 0, 0), (0, 0, 255), (0, 160, 0)


def card(texture: Any, uv: Any = UV, colors: Any = None, mode: Any = "OPAQUE", factor: Any = (1, 1, 1, 1), **more: Any) -> Mesh:
    texture = texture if isinstance(texture, ColorTexture) else ColorTexture(np.asarray(texture, np.uint8), **more)
    material = Material(factor, texture, mode)
    return Mesh(CORNERS, FACES, vertex_colors=colors, uv=np.asarray(uv, np.float32), material=material)


def halves(left: tuple[int, ...], right: tuple[int, ...], size: int = 64) -> np.ndarray:
    image = np.empty((size, size, len(left)), np.uint8)
    image[:, : size // 2], image[:, size // 2 :] = left, right
    return image


def hole() -> np.ndarray:
    """Green, opaque in the middle quarter only."""
    image = np.zeros((64, 64, 4), np.uint8)
    image[..., :3], image[16:48, 16:48, 3] = GREEN, 255
    return image


@pytest.fixture(scope="module")
def drawn(provider: str) -> Any:
    renderer = Renderer(provider)

    def draw(*meshes: Mesh, aov: str = "color", camera: Camera = CAMERA, size: tuple[int, int] = SIZE) -> Any:
        return renderer.render(Scene(meshes), camera, size, aovs=(aov,)).arrays[aov]

    yield draw
    renderer.release()


def test_a_texture_is_drawn_between_vertices(drawn: Any) -> None:
    """Two triangles, and each side of the picture has its colour up to the seam."""
    image = drawn(card(halves(RED, BLUE)))
    assert (image[:, :31] == RED).all() and (image[:, 33:] == BLUE).all()
    checks = (np.indices((64, 64)) // 8).sum(0) % 2 * 255
    checker = np.repeat(checks[..., None], 3, 2)
    assert np.array_equal(drawn(card(checker)), checker)


def test_row_0_of_the_picture_is_on_top(drawn: Any) -> None:
    image = drawn(card(halves(RED, BLUE).transpose(1, 0, 2)))
    assert (image[:31] == RED).all() and (image[33:] == BLUE).all()


@pytest.mark.parametrize(("wrap", "colors"), [("repeat", "RBRB"), ("mirror", "RBBR"), ("clamp", "RBBB")])
def test_wrapping(drawn: Any, wrap: str, colors: str) -> None:
    """Two pictures side by side where there is room for two."""
    image = drawn(card(halves(RED, BLUE), UV * (2, 1), wrap=(wrap, "repeat")))
    found = "".join("R" if image[32, x, 0] == 255 else "B" for x in (8, 24, 40, 56))
    assert found == colors


def test_base_colour_is_a_product_of_linear_light_encoded_once(drawn: Any) -> None:
    """glTF 2.0, 3.9.2."""
    colors = np.full((4, 4), 188, np.uint8)
    colors[:, 3] = 255
    image = drawn(card(np.full((4, 4, 3), 188), colors=colors, factor=(1, 0.5, 0.25, 1)))
    light = decode(np.array(188 / 255)) ** 2 * np.array([1, 0.5, 0.25])
    np.testing.assert_allclose(image[32, 32], np.round(encode(light) * 255), atol=1)


def test_texels_are_blended_as_light(drawn: Any) -> None:
    """Magnified, between black and white: half of the light, not half of the code. ``nearest`` blends nothing."""
    black_white = np.zeros((1, 2, 3), np.uint8)
    black_white[0, 1] = 255
    smooth = drawn(card(black_white, wrap=("clamp", "clamp")))[32, :, 0].astype(int)
    expected = encode(decode(texels_at(ColorTexture(black_white, ("clamp", "clamp")), np.array([[0.0, 0.5]]))[0, :1])) * 255
    assert smooth[0] == expected[0] == 0 and smooth[-1] == 255 and (np.diff(smooth) >= 0).all()
    assert abs(int(smooth[31:33].mean()) - 188) <= 3
    hard = drawn(card(black_white, nearest=True))[32, :, 0]
    assert set(np.unique(hard)) == {0, 255} and hard[31] == 0 and hard[32] == 255


def test_what_is_far_away_does_not_flicker(drawn: Any) -> None:
    """Texels of a thousandth of a pixel: smaller copies give their mean light, also of a size that is no power of two."""
    noise = np.where(np.random.default_rng(1).random((63, 127, 1)) < 0.5, 0, 255).astype(np.uint8).repeat(3, 2)
    image = drawn(card(noise, UV * 90)).astype(float)
    assert image.std() < 8 and abs(image.mean() - 188) < 12
    assert drawn(card(noise, UV * 90, mipmaps=False)).std() > 60


def test_cut_outs_are_cut_from_all(drawn: Any) -> None:
    """Colour, depth, normals; OPAQUE stays whole, BLEND is cut at one half."""
    for mode in ("MASK", "BLEND"):
        depth = drawn(card(hole(), mode=mode), aov="depth")
        assert depth[32, 32] == 3 and depth[4, 4] == 0 and (depth > 0).mean() == pytest.approx(0.25, abs=0.02)
        color = drawn(card(hole(), mode=mode))
        assert (color[32, 32] == GREEN).all() and np.array_equal((color == GREEN).all(2), depth > 0)
        assert np.array_equal(np.abs(drawn(card(hole(), mode=mode), aov="normal")).sum(2) > 0, depth > 0)
    assert (drawn(card(hole()), aov="depth") == 3).all()


def test_vertex_alpha_cuts_without_a_texture(drawn: Any) -> None:
    colors = np.full((4, 4), 255, np.uint8)
    colors[[0, 2], 3] = 0
    mesh = Mesh(CORNERS, FACES, vertex_colors=colors, material=Material(alpha_mode="MASK"))
    depth = drawn(mesh, aov="depth")
    assert (depth[:, :31] == 0).all() and (depth[:, 33:] == 3).all()


def test_a_cut_out_occludes_where_it_is(drawn: Any) -> None:
    """A leaf before a wall: behind its hole the wall is as open as without it."""
    wall = dataclasses.replace(card(np.full((1, 1, 3), 255)), transforms=np.diag([3.0, 3, 1, 1])[None])
    near = np.eye(4)
    near[2, 3] = 0.05
    pictures = [
        drawn(wall, dataclasses.replace(card(texels, mode="MASK"), transforms=near[None]), aov="visibility")
        for texels in (hole(), hole() * (1, 1, 1, 0))
    ]
    leaf, nothing = pictures
    assert nothing.min() > 0.99 and leaf[14, 32] < nothing[14, 32] - 0.05
    assert leaf[4, 4] > 0.99


@pytest.mark.parametrize("layers", [1, 2])
def test_what_is_all_hole_changes_no_byte(provider: str, layers: int) -> None:
    """Not the first layer, and not the one behind it."""
    wall = dataclasses.replace(card(np.full((1, 1, 3), 255)), transforms=(_moved(-0.1) @ np.diag([3.0, 3, 1, 1]))[None])
    front = dataclasses.replace(card(np.full((1, 1, 3), 255)), transforms=(np.diag([0.5, 0.5, 1, 1]))[None])
    holes = dataclasses.replace(card(hole(), UV * 0.2, mode="MASK"), transforms=_moved(-0.05)[None])
    assert holes.can_show and holes.cutoff == 0.5
    settings = ao.Settings(method=ao.Bitmask(layers=layers))
    with Renderer(provider) as renderer:
        bare, more = (renderer.render(Scene(m), CAMERA, SIZE, settings) for m in ([front, wall], [front, holes, wall]))
    assert bare.visibility.min() < 0.9
    for name in bare.arrays:
        assert np.array_equal(bare.arrays[name], more.arrays[name]), name


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
def test_rays_see_the_same_holes(drawn: Any, provider: str, wrap: str) -> None:
    """Primary rays and the G-buffer, pixel by pixel, of a leaf that is turned away."""
    pytest.importorskip("embreex")
    from ssao_gl.truth.surface import surface

    speckled = np.full((37, 53, 4), 255, np.uint8)
    speckled[..., 3] = np.random.default_rng(2).integers(0, 256, (37, 53))
    mesh = card(speckled, UV * 2 - 0.5, mode="MASK", wrap=(wrap, wrap))
    behind = dataclasses.replace(mesh, transforms=_moved(-0.5)[None])
    camera = Camera.perspective(0.9, 0.1, 20, look_at((1.5, 0.7, 1.8), (0, 0, 0)))
    seen = surface(Scene([mesh, behind]), camera, (160, 120)).depth
    depth = drawn(mesh, behind, aov="depth", camera=camera, size=(160, 120))
    assert 0.1 < (seen > 0).mean() < 0.9
    # SwiftShader snaps vertices to a sixteenth of a pixel.
    assert (np.abs(seen - depth) > 1e-3).mean() < (0.01 if provider == "swiftshader" else 0.002)


def test_pictures_larger_than_the_driver_takes_are_thinned() -> None:
    assert _fitting(np.zeros((3, 9, 3), np.uint8), 4).shape == (1, 3, 3)
    assert _fitting(np.zeros((3, 4, 3), np.uint8), 4).shape == (3, 4, 3)


def _moved(z: float) -> np.ndarray:
    place = np.eye(4)
    place[2, 3] = z
    return place
