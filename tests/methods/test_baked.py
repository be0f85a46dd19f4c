"""What a file keeps, drawn through the G-buffer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.bake.settings import Baking, OcclusionTexture, Vertices
from ssao_gl.loaders.load import load_scene
from ssao_gl.scene.baked_visibility import BakedTexture, BakedVisibility
from ssao_gl.scene.model import Mesh, Scene

from ..loaders.gltf_parts import FACES, QUAD, UV, Parts

CAMERA = ao.Camera.orthographic(2.0, 0.1, 10.0, np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1.0]]))
"""Sees the quad of 2 x 2 units as the whole image."""
BAKED = ao.Settings(method=ao.method("baked"))
ROWS = np.array([0, 0, 1, 1], np.float32)
"""Dark below, open above."""
RAMP = (np.arange(32)[::-1, None] + 0.5) / 32
STEP = 1e-3
"""Of half floats."""


def quad(baked: BakedVisibility | None, **more: object) -> Scene:
    return Scene([replace(Mesh(QUAD, FACES.reshape(-1, 3).astype("u4"), baked=baked), **more)])  # type: ignore[arg-type]


def seen(renderer: ao.Renderer, scene: Scene, settings: ao.Settings = BAKED) -> np.ndarray:
    return renderer.render(scene, CAMERA, (32, 32), settings, aovs=("visibility",)).visibility


def loaded(parts: Parts, primitive: dict[str, object], folder: Path) -> Scene:
    (folder / "a.glb").write_bytes(parts.show(primitive))
    return load_scene(folder / "a.glb")


def test_vertices_are_interpolated(renderer: ao.Renderer) -> None:
    assert np.abs(seen(renderer, quad(BakedVisibility(ROWS))) - RAMP).max() < STEP


def test_half_of_the_strength_is_half_of_the_occlusion(renderer: ao.Renderer) -> None:
    half = ao.Settings(method=ao.registry()["baked"](intensity=0.5))
    assert np.abs(seen(renderer, quad(BakedVisibility(ROWS)), half) - (1 + RAMP) / 2).max() < STEP


def test_a_texture_is_read_as_numbers_and_only_when_it_is_wanted(renderer: ao.Renderer) -> None:
    unpacked = []

    def picture() -> np.ndarray:
        unpacked.append(1)
        return np.full((4, 4, 3), (51, 255, 0), np.uint8)

    scene = quad(BakedVisibility(UV, BakedTexture(picture), 0.5))
    renderer.render(scene, CAMERA, (32, 32), ao.Settings(), aovs=("image",))
    assert not unpacked
    assert np.abs(seen(renderer, scene) - 0.6).max() < STEP and len(unpacked) == 1


@pytest.mark.parametrize("kept", ["_AO", "COLOR_0", "texture", "_AO beside a texture"])
def test_what_a_file_keeps(renderer: ao.Renderer, kept: str, tmp_path: Path) -> None:
    parts = Parts()
    attributes = {"TEXCOORD_0": parts.accessor(UV)}
    if "texture" in kept:
        parts.texture(np.full((4, 4, 3), 128 if "_AO" in kept else 51))
        parts.tree["materials"] = [{"occlusionTexture": {"index": 0}}]
    if "_AO" in kept:
        attributes["_AO"] = parts.accessor(ROWS[:, None])
    if kept == "COLOR_0":
        attributes["COLOR_0"] = parts.accessor(np.repeat(ROWS[:, None], 3, 1))
    primitive = parts.quad(**attributes) | ({"material": 0} if "texture" in kept else {})
    expected = 0.2 if kept == "texture" else RAMP
    assert np.abs(seen(renderer, loaded(parts, primitive, tmp_path)) - expected).max() < STEP


def test_occlusion_in_vertex_colours_does_not_darken_twice(renderer: ao.Renderer, tmp_path: Path) -> None:
    """Its base colour is that of the material alone; other methods show the colours as they are."""
    parts = Parts(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1]}}])
    grey = np.full((4, 3), 0.25, "f4")
    scene = loaded(parts, parts.quad(COLOR_0=parts.accessor(grey)) | {"material": 0}, tmp_path)
    colors = [
        renderer.render(scene, CAMERA, (8, 8), settings, aovs=("color", "visibility")).arrays["color"][4, 4, :3]
        for settings in (BAKED, ao.Settings())
    ]
    assert np.abs(colors[0].astype(int) - (188, 137, 255)).max() <= 1
    assert np.abs(colors[1].astype(int) - (99, 71, 137)).max() <= 1


def test_meshes_without_any_are_open_and_so_is_the_background(renderer: ao.Renderer) -> None:
    half = QUAD * np.float32(0.5)
    front = Mesh(half + np.float32([0, 0, 0.5]), FACES.reshape(-1, 3).astype("u4"), baked=BakedVisibility(0 * ROWS))
    found = seen(renderer, Scene([front, Mesh(half + np.float32([0.75, 0, 0]), front.triangles)]))
    assert (found[12:20, 10:22] == 0).all() and (found[:, 25:] == 1).all() and (found[:6] == 1).all()


@pytest.mark.parametrize(
    "colors", [None, np.ones((4, 3), "f4"), np.tile(np.float32([1, 0.5, 0.2]), (4, 1))], ids=["none", "white", "coloured"]
)
def test_a_file_that_keeps_nothing_is_refused(renderer: ao.Renderer, colors: np.ndarray | None, tmp_path: Path) -> None:
    parts = Parts()
    primitive = parts.quad() if colors is None else parts.quad(COLOR_0=parts.accessor(colors))
    with pytest.raises(ao.SettingsError, match=r"baked: a\.glb keeps no occlusion.*ssao-gl bake"):
        seen(renderer, loaded(parts, primitive, tmp_path))


def test_depth_buffers_are_refused(renderer: ao.Renderer) -> None:
    with pytest.raises(ao.SettingsError, match="baked: needs a scene"):
        renderer.apply(np.ones((8, 8), np.float32), ao.Camera.perspective(1.0), settings=BAKED)


def test_a_texture_that_cannot_be_unpacked_is_one_line(renderer: ao.Renderer, tmp_path: Path) -> None:
    parts = Parts()
    parts.texture(np.zeros((4, 4, 3)))
    parts.tree["images"][0]["bufferView"] = parts.view(b"no picture")
    parts.tree["materials"] = [{"occlusionTexture": {"index": 0}}]
    scene = loaded(parts, parts.quad(TEXCOORD_0=parts.accessor(UV)) | {"material": 0}, tmp_path)
    with pytest.raises(ao.SceneError, match="occlusion texture of material '0': cannot be read"):
        seen(renderer, scene)


def test_rows_must_fit() -> None:
    with pytest.raises(ao.SceneError, match=r"baked must have rows \(4,\), got \(3,\)"):
        quad(BakedVisibility(ROWS[:3]))


@pytest.mark.parametrize(
    "to", [Vertices(), Vertices(attribute="_AO"), OcclusionTexture(size=16)], ids=["color", "_AO", "texture"]
)
def test_what_bake_writes_is_what_is_shown(renderer: ao.Renderer, to: Vertices | OcclusionTexture, tmp_path: Path) -> None:
    """A wall before which half of another stands: grey behind it, and as grey as was baked."""
    pytest.importorskip("embreex")
    faces = FACES.reshape(-1, 3).astype("u4")
    before = Mesh(QUAD * np.float32([0.5, 1, 1]) + np.float32([-3, 0, 1]), faces)
    baked = ao.bake(Scene([Mesh(QUAD, faces), before]), Baking(radius=9, spp=64), to=to)
    baked.save(tmp_path / "b.glb")
    found = seen(renderer, load_scene(tmp_path / "b.glb"))
    if isinstance(to, OcclusionTexture):
        assert found.min() < 0.99 and abs(found.mean() - baked.meshes[0].visibility.mean()) < 0.05
    else:
        kept = baked.meshes[0].visibility
        assert kept.min() < 0.99 and np.abs(found[[-1, -1, 0, 0], [0, -1, 0, -1]] - kept).max() < 0.02
