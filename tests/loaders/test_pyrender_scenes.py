"""Scenes of pyrender are read as they are: cameras, poses, instances, normals and colours."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.loaders.as_scene import as_camera, as_scene
from ssao_gl.loaders.pyrender_scenes import camera_from_pyrender, from_pyrender
from ssao_gl.scene.lens import Orthographic, Perspective
from ssao_gl.scene.model import Mesh, Scene

from ..colors import colors_at_vertices

os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
try:
    import pyrender
except (ImportError, AttributeError) as reason:  # it loads an OpenGL library as soon as it is imported
    pytest.skip(f"pyrender cannot be imported: {reason}", allow_module_level=True)

SIZE = (80, 60)
POSE = ao.look_at((3, 2, 4), (0, 0, 0))


def scene_of(*meshes: object, camera: object = None) -> pyrender.Scene:
    scene = pyrender.Scene(name="test")
    for mesh in meshes:
        scene.add(mesh)
    if camera is not None:
        scene.add(camera, pose=POSE)
    return scene


def box(**options: object) -> pyrender.Mesh:
    return pyrender.Mesh.from_trimesh(trimesh.creation.box((1, 2, 3)), **options)


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        (pyrender.PerspectiveCamera(yfov=0.8, znear=0.1, zfar=20.0), Perspective(0.8, 0.1, 20.0)),
        (pyrender.PerspectiveCamera(yfov=0.8, znear=0.1), Perspective(0.8, 0.1)),
        (pyrender.OrthographicCamera(xmag=2.0 * 4 / 3, ymag=2.0, znear=0.1, zfar=20.0), Orthographic(4.0, 0.1, 20.0)),
    ],
    ids=["finite", "infinite", "orthographic"],
)
def test_cameras_have_the_same_projection(theirs: object, ours: object) -> None:
    camera = camera_from_pyrender(scene_of(box(), camera=theirs))
    np.testing.assert_allclose(camera.lens.matrix(SIZE), ours.matrix(SIZE), atol=1e-12)  # type: ignore[attr-defined]
    np.testing.assert_allclose(camera.pose, POSE, atol=1e-12)  # pyrender keeps quaternions
    assert math.isinf(camera.view(SIZE).far) == (getattr(theirs, "zfar", None) is None)


def test_an_intrinsics_camera_is_off_centre() -> None:
    theirs = pyrender.IntrinsicsCamera(fx=70.0, fy=72.0, cx=35.0, cy=33.0, znear=0.1, zfar=20.0)
    ours = ao.Camera.pinhole(70, 72, 35, 33, SIZE, znear=0.1, zfar=20.0)
    view = camera_from_pyrender(scene_of(box(), camera=theirs)).view(SIZE)
    z = np.full(SIZE[::-1], 2.0)
    np.testing.assert_allclose(view.points(z), ours.view(SIZE).points(z), atol=1e-9)
    np.testing.assert_allclose(view.projection, theirs.get_projection_matrix(*SIZE), atol=1e-12)


def test_poses_and_instances_are_kept_as_instances() -> None:
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = (0, 2, 4)
    scene = scene_of(camera=pyrender.PerspectiveCamera(yfov=1.0))
    node = pyrender.Node(matrix=trimesh.transformations.translation_matrix((0, 5, 0)))
    scene.add_node(node)
    scene.add(box(poses=poses), pose=trimesh.transformations.rotation_matrix(0.5, (0, 0, 1)), parent_node=node)
    (draw,) = from_pyrender(scene).meshes
    assert draw.transforms.shape == (3, 4, 4) and len(draw.triangles) == 12
    expected = trimesh.transformations.translation_matrix((0, 5, 0)) @ trimesh.transformations.rotation_matrix(0.5, (0, 0, 1))
    np.testing.assert_allclose(draw.transforms, expected @ poses, atol=1e-12)


def test_smooth_and_flat() -> None:
    (smooth,), (flat,) = (from_pyrender(scene_of(box(smooth=s))).meshes for s in (True, False))
    assert smooth.normals is not None and len(smooth.positions) < len(flat.positions) == 36
    assert flat.normals is not None
    np.testing.assert_allclose(np.abs(flat.normals).max(1), 1, atol=1e-6)
    bare = pyrender.Mesh([pyrender.Primitive(positions=np.eye(3), mode=4)])
    (draw,) = from_pyrender(scene_of(bare)).meshes
    assert draw.normals is None and draw.triangles.tolist() == [[0, 1, 2]]


def test_colours() -> None:
    red = pyrender.MetallicRoughnessMaterial(baseColorFactor=[0.5, 0.0, 1.0, 1.0])
    (draw,) = from_pyrender(scene_of(box(material=red))).meshes
    np.testing.assert_allclose(draw.color, (0.7353, 0, 1), atol=1e-3)  # factors are linear, ours are sRGB
    assert draw.vertex_colors is None
    painted = trimesh.creation.box()
    painted.visual.vertex_colors = [10, 20, 30, 255]
    (draw,) = from_pyrender(scene_of(pyrender.Mesh.from_trimesh(painted))).meshes
    assert draw.vertex_colors is not None and (draw.vertex_colors == [56, 79, 96, 255]).all(), "linear light"


def test_a_texture_is_sampled_at_the_vertices() -> None:
    image = np.zeros((2, 2, 3), np.uint8)
    image[0, 0], image[1, 1] = (255, 0, 0), (0, 0, 255)  # upper left red, lower right blue
    material = pyrender.MetallicRoughnessMaterial(baseColorTexture=pyrender.Texture(source=image, source_channels="RGB"))
    uv = np.array([[0.1, 0.9], [0.9, 0.1], [0.1, 0.1]])
    mesh = pyrender.Mesh([pyrender.Primitive(positions=np.eye(3), texcoord_0=uv, material=material, mode=4)])
    (draw,) = from_pyrender(scene_of(mesh)).meshes
    assert colors_at_vertices(draw).tolist() == [[255, 0, 0, 255], [0, 0, 255, 255], [0, 0, 0, 255]]


def test_invisible_meshes_and_strays_are_left_out() -> None:
    hidden = box(is_visible=False)
    points = pyrender.Mesh.from_points(np.eye(3))
    stray = pyrender.Mesh([pyrender.Primitive(positions=np.arange(12.0).reshape(4, 3), mode=4)])
    assert len(from_pyrender(scene_of(hidden, points, box())).meshes) == 2
    assert from_pyrender(scene_of(stray)).triangles == 1  # a fourth vertex makes no triangle
    for meshes in ((), (hidden,)):
        with pytest.raises(ao.SceneError, match="the pyrender scene has no triangles to draw"):
            from_pyrender(scene_of(*meshes))


def test_a_scene_of_a_class_of_ones_own() -> None:
    class Robot(pyrender.Scene):  # type: ignore[misc]
        pass

    robot = Robot()
    robot.add(box())
    assert as_scene(robot).triangles == 12


def test_without_a_camera() -> None:
    scene = scene_of(box())
    assert list(as_scene(scene).cameras) == []
    with pytest.raises(ao.SceneError, match="the pyrender scene has no camera; add one"):
        as_camera(scene)
    with pytest.raises(ao.SceneError, match="no camera"):
        ao.apply(None, np.ones((4, 4)), scene)


def test_the_same_picture_as_our_own_scene(any_renderer: ao.Renderer) -> None:
    mesh = trimesh.creation.box((1, 2, 3))
    floor = trimesh.creation.box((8, 0.1, 8))
    floor.apply_translation((0, -1.05, 0))
    stone = pyrender.MetallicRoughnessMaterial(baseColorFactor=[1.0, 1.0, 1.0, 1.0])
    theirs = scene_of(
        *(pyrender.Mesh.from_trimesh(m, material=stone, smooth=False) for m in (mesh, floor)),
        camera=pyrender.PerspectiveCamera(yfov=0.9, znear=0.5, zfar=20.0),
    )
    draws = [
        Mesh(
            m.vertices[m.faces].reshape(-1, 3).astype(np.float32),
            np.arange(36, dtype=np.uint32).reshape(-1, 3),
            np.repeat(m.face_normals, 3, axis=0).astype(np.float32),
            (1.0, 1.0, 1.0),
        )
        for m in (mesh, floor)
    ]
    white = (1.0, 1.0, 1.0, 1.0)  # pyrender's own default
    ours = Scene(draws, cameras=[ao.Camera.perspective(0.9, 0.5, 20.0, as_camera(theirs).pose)], background=white)
    asked = {"size": (160, 120), "aovs": ("image", "visibility", "depth", "normal")}
    first, second = (any_renderer.render(as_scene(scene), **asked) for scene in (theirs, ours))  # type: ignore[arg-type]
    assert first.visibility.min() < 0.9 and first.image.std() > 5
    for name in first.arrays:
        np.testing.assert_array_equal(first.arrays[name], second.arrays[name])
