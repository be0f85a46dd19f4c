"""The stand-in for pyrender's OffscreenRenderer, over scenes of the real pyrender."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest
import trimesh

import ssao_gl as ao

os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
try:
    import pyrender
except (ImportError, AttributeError) as reason:  # it loads an OpenGL library as soon as it is imported
    pytest.skip(f"pyrender cannot be imported: {reason}", allow_module_level=True)

pytestmark = pytest.mark.gl
FLAGS = pyrender.RenderFlags


@pytest.fixture(scope="module")
def renderer() -> Any:
    with ao.OffscreenRenderer(64, 48, settings=ao.Settings(method=ao.Bitmask(radius=0.5))) as made:
        yield made


@pytest.fixture
def scene() -> Any:
    made = pyrender.Scene(bg_color=[0.0, 1.0, 0.0])
    clay = pyrender.MetallicRoughnessMaterial(baseColorFactor=[0.5, 0.2, 0.1, 1])
    made.add(pyrender.Mesh.from_trimesh(trimesh.creation.box((4, 0.2, 4)), material=clay), name="floor")
    made.add(pyrender.Mesh.from_trimesh(trimesh.creation.icosphere(radius=0.8), material=clay), name="ball", pose=np.eye(4))
    made.add(pyrender.PerspectiveCamera(yfov=0.8, znear=0.1), pose=ao.look_at((3, 2.5, 4), (0, 0, 0)))
    return made


def node(scene: Any, name: str) -> Any:
    (found,) = scene.get_nodes(name=name)
    return found


def test_the_same_as_render(renderer: Any, scene: Any) -> None:
    color, depth = renderer.render(scene)
    picture = ao.render(scene, size=(64, 48), method=ao.Bitmask(radius=0.5), aovs=("image", "depth"))
    np.testing.assert_array_equal(color, picture.image)
    np.testing.assert_array_equal(depth, picture.depth)
    assert tuple(color[0, 0]) == (0, 255, 0) and depth[0, 0] == 0
    np.testing.assert_array_equal(renderer.render(scene, FLAGS.DEPTH_ONLY | FLAGS.OFFSCREEN), depth)


def test_alpha_and_flat_light(renderer: Any, scene: Any) -> None:
    color, _ = renderer.render(scene, FLAGS.RGBA)
    assert color.shape == (48, 64, 4) and (color[..., 3] == 255).all()
    scene.bg_color = [0.0, 1.0, 0.0, 0.0]
    color, depth = renderer.render(scene, FLAGS.RGBA | FLAGS.SKIP_CULL_FACES)
    assert ((color[..., 3] == 0) == (depth == 0)).all()
    assert renderer.render(scene)[0].shape == (48, 64, 3)
    flat, _ = renderer.render(scene, FLAGS.FLAT)
    painted = flat[depth > 0].astype(int)
    base = np.array([188, 124, 89])  # sRGB of the clay
    assert np.abs(painted.max(0) - base).max() <= 2 and painted[:, 2].min() < 82, "base colour, dimmed by occlusion alone"


def test_segments_have_exactly_their_colors(renderer: Any, scene: Any) -> None:
    floor, ball = node(scene, "floor"), node(scene, "ball")
    color, depth = renderer.render(scene, FLAGS.SEG, {floor: (1, 2, 253), ball: 77})
    assert {tuple(c) for c in np.unique(color.reshape(-1, 3), axis=0)} == {(0, 0, 0), (1, 2, 253), (77, 77, 77)}
    np.testing.assert_array_equal(depth, renderer.render(scene)[1])
    alone, _ = renderer.render(scene, FLAGS.SEG, {ball: (200, 10, 10)})
    assert {tuple(c) for c in np.unique(alone.reshape(-1, 3), axis=0)} == {(0, 0, 0), (200, 10, 10)}
    for value in range(0, 256, 5):
        assert renderer.render(scene, FLAGS.SEG, {ball: value})[0].max() == value


def test_what_is_not_drawn_is_told(renderer: Any, scene: Any) -> None:
    with pytest.raises(ao.SettingsError, match="ALL_WIREFRAME, FACE_NORMALS draws lines"):
        renderer.render(scene, FLAGS.ALL_WIREFRAME | FLAGS.FACE_NORMALS)
    with pytest.raises(ao.SettingsError, match="seg_node_map"):
        renderer.render(scene, FLAGS.SEG)
    with pytest.raises(ao.SceneError, match="expected one number or three"):
        renderer.render(scene, FLAGS.SEG, {node(scene, "ball"): (1, 2)})
    with pytest.warns(ao.InputWarning, match="SHADOWS"):
        renderer.render(scene, FLAGS.SHADOWS_ALL)
