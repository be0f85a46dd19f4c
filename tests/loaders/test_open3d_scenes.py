"""Meshes, point clouds, RGB-D images and cameras of the real Open3D."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.loaders.as_scene import as_camera, as_scene

from ..packages import needed


@pytest.fixture(scope="module")
def open3d() -> Any:
    return needed("open3d")


@pytest.mark.parametrize("tensor", [False, True])
def test_meshes_and_clouds(open3d: Any, tensor: bool) -> None:
    mesh = open3d.geometry.TriangleMesh.create_torus()
    mesh.compute_vertex_normals()
    mesh.paint_uniform_color((0.2, 0.4, 1.0))
    cloud = mesh.sample_points_uniformly(500)
    vertices, normals = np.asarray(mesh.vertices), np.asarray(mesh.vertex_normals)
    if tensor:
        mesh, cloud = open3d.t.geometry.TriangleMesh.from_legacy(mesh), open3d.t.geometry.PointCloud.from_legacy(cloud)
    surface, points = as_scene([mesh, cloud]).meshes
    np.testing.assert_allclose(surface.positions, vertices, atol=1e-6)
    assert surface.normals is not None and surface.vertex_colors is not None and points.vertex_colors is not None
    np.testing.assert_allclose(surface.normals, normals, atol=1e-6)
    assert (surface.vertex_colors == (51, 102, 255, 255)).all() and (points.vertex_colors == (51, 102, 255, 255)).all()
    assert surface.piece_count == 1200 and points.piece_count >= 500


def test_what_cannot_be_drawn_is_told(open3d: Any) -> None:
    with pytest.raises(ao.SceneError, match="has no triangles"):
        as_scene(open3d.geometry.TriangleMesh())
    with pytest.raises(ao.SceneError, match="is empty"):
        as_scene(open3d.geometry.PointCloud())
    with pytest.raises(ao.SceneError, match="Open3D's LineSet"):
        as_scene(open3d.geometry.LineSet())


@pytest.mark.gl
def test_textures_lie_as_in_the_file_itself(open3d: Any, tmp_path: Path, any_renderer: ao.Renderer) -> None:
    picture = np.random.default_rng(2).integers(0, 255, (4, 6, 3), np.uint8)
    Image.fromarray(picture).save(tmp_path / "t.png")
    (tmp_path / "q.mtl").write_text("newmtl m\nmap_Kd t.png\n")
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    (tmp_path / "q.obj").write_text(f"mtllib q.mtl\nusemtl m\n{corners}f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
    camera = ao.Camera.perspective(0.9, pose=ao.look_at((0.2, 0.1, 3), (0, 0, 0)))
    own = any_renderer.render(ao.load_scene(tmp_path / "q.obj"), camera, (60, 48), aovs=("color",)).color
    theirs = as_scene(open3d.io.read_triangle_mesh(str(tmp_path / "q.obj")))
    found = any_renderer.render(theirs, camera, (60, 48), aovs=("color",)).color
    assert len(np.unique(own.reshape(-1, 3), axis=0)) > 20
    assert np.abs(found.astype(int) - own).max() <= 1


@pytest.mark.gl
def test_rgbd_images_of_both_interfaces(open3d: Any, any_renderer: ao.Renderer) -> None:
    w, h = 48, 32
    depth = np.full((h, w), 1500, np.uint16)
    depth[8:24, 16:32] = 1200
    color = np.full((h, w, 3), 200, np.uint8)
    intrinsic = open3d.camera.PinholeCameraIntrinsic(w, h, 40, 40, 24, 16)
    legacy = open3d.geometry.RGBDImage.create_from_color_and_depth(
        open3d.geometry.Image(color), open3d.geometry.Image(depth), convert_rgb_to_intensity=False
    )
    tensor = open3d.t.geometry.Image(open3d.core.Tensor(depth[..., None]))
    method = ao.Bitmask(radius=0.4)
    wanted = ao.apply(color, depth, as_camera(intrinsic), depth_scale=0.001, method=method).image
    assert wanted.min() < 190 < wanted.max()
    assert np.abs(ao.apply(legacy.color, legacy.depth, intrinsic, method=method).image.astype(int) - wanted).max() <= 1
    visibility = ao.occlusion(tensor, intrinsic, depth_scale=0.001, method=method)
    np.testing.assert_array_equal(visibility, ao.occlusion(depth, intrinsic, depth_scale=0.001, method=method))


def test_the_camera_of_a_renderer() -> None:
    class Camera:
        """What ``open3d.visualization.rendering.Camera`` offers, which only comes with a renderer."""

        def get_projection_matrix(self) -> Any:
            return np.array([[0.9, 0, 0, 0], [0, 1.7, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]], np.float32)

        def get_model_matrix(self) -> Any:
            return ao.look_at((3, 2, 2), (0, 0, 0), (0, 0, 1)).astype(np.float32)

    found = as_camera(Camera())
    np.testing.assert_allclose(found.pose[:3, 3], (3, 2, 2), atol=1e-6)
    assert found.view((170, 90)).near == pytest.approx(0.1) and np.isinf(found.view((170, 90)).far)
