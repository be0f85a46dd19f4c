"""Plotters and data sets of the real PyVista."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.loaders.as_scene import as_camera, as_scene

from ..packages import needed

SIZE = (96, 64)


@pytest.fixture(scope="module")
def pyvista() -> Any:
    return needed("pyvista")


@pytest.fixture
def plotter(pyvista: Any) -> Iterator[Any]:
    made = pyvista.Plotter(off_screen=True, window_size=SIZE)
    yield made
    made.close()


def test_colors_are_those_that_vtk_maps(pyvista: Any, plotter: Any) -> None:
    plane = pyvista.Plane(i_resolution=2, j_resolution=1)
    plane.cell_data["value"] = [0.0, 1.0]
    plotter.add_mesh(plane, scalars="value", cmap=["#ff0000", "#0000ff"], show_scalar_bar=False)
    plotter.add_mesh(pyvista.Sphere(), color="#20c040", opacity=0.75, name="ball")
    line = pyvista.Plane(i_resolution=1, j_resolution=1)
    line["height"] = line.points[:, 0]
    plotter.add_mesh(line, scalars="height", cmap=["#000000", "#ffffff"], show_scalar_bar=False)
    by_cell, ball, by_point = ao.from_pyvista(plotter).meshes
    assert by_cell.vertex_colors is not None and {tuple(c) for c in by_cell.vertex_colors} == {
        (255, 0, 0, 255),
        (0, 0, 255, 255),
    }
    assert ball.name == "ball" and ball.vertex_colors is None and ball.material is not None
    np.testing.assert_allclose(ball.color, [0x20 / 255, 0xC0 / 255, 0x40 / 255], atol=1e-6)
    assert ball.material.alpha_mode == "BLEND" and ball.material.base_color[3] == 0.75
    assert by_point.vertex_colors is not None
    dark = by_point.positions[:, 0] < 0
    assert (by_point.vertex_colors[dark, 0] == 0).all() and (by_point.vertex_colors[~dark, 0] == 255).all()


def test_what_is_no_surface_is_named_and_left_out(pyvista: Any, plotter: Any) -> None:
    plotter.add_mesh(pyvista.Line(), color="red")
    plotter.add_mesh(pyvista.Cube(), style="wireframe")
    plotter.add_mesh(pyvista.Sphere(), name="hidden").visibility = False
    plotter.add_axes()
    with pytest.raises(ao.SceneError, match="lines are left out"):
        ao.from_pyvista(plotter)
    plotter.add_mesh(pyvista.Cube(), name="cube", smooth_shading=True, split_sharp_edges=True)
    plotter.add_points(pyvista.Sphere().points, color="blue", name="dots")
    plotter.set_background("#102030")
    scene = ao.from_pyvista(plotter)
    assert [mesh.name for mesh in scene.meshes] == ["cube", "dots"]
    assert scene.warnings == ("lines are left out", "wireframes are left out")
    np.testing.assert_allclose(scene.background, [0x10 / 255, 0x20 / 255, 0x30 / 255, 1])
    dots = scene.meshes[1].vertex_colors
    assert dots is not None and (dots == (0, 0, 255, 255)).all()
    assert scene.up == (0, 0, 1)


def test_data_sets_blocks_and_bytes(pyvista: Any) -> None:
    cube, grid = pyvista.Cube(), pyvista.ImageData(dimensions=(4, 4, 4)).cast_to_unstructured_grid()
    cube["paint"] = np.tile(np.uint8([10, 200, 30]), (cube.n_points, 1))
    scene = as_scene(pyvista.MultiBlock({"cube": cube, "none": None, "more": pyvista.MultiBlock([grid])}))
    assert [mesh.piece_count for mesh in scene.meshes] == [12, 6 * 9 * 2]
    assert scene.meshes[0].vertex_colors is not None and (scene.meshes[0].vertex_colors == (10, 200, 30, 255)).all()
    assert scene.meshes[1].vertex_colors is None
    assert as_scene(pyvista.PolyData(np.random.default_rng(1).normal(size=(50, 3)))).triangles > 50
    with pytest.raises(ao.SceneError, match="expected a Plotter or data set"):
        ao.from_pyvista(3)  # type: ignore[arg-type]


def test_textures_lie_where_vtk_puts_them(pyvista: Any, plotter: Any) -> None:
    picture = np.zeros((2, 2, 3), np.uint8)
    picture[0, 0], picture[1, 1] = (255, 0, 0), (0, 0, 255)  # the upper left is red
    plotter.add_mesh(pyvista.Plane(i_resolution=1, j_resolution=1), texture=pyvista.Texture(picture))
    (mesh,) = ao.from_pyvista(plotter).meshes
    assert mesh.texture is not None and mesh.uv is not None and (mesh.texture.array == picture).all()
    corner = int(np.argmin(mesh.positions[:, 0] - mesh.positions[:, 1]))  # low x, high y
    np.testing.assert_allclose(mesh.uv[corner], [0, 0], atol=1e-6)


@pytest.mark.gl
@pytest.mark.parametrize("parallel", [False, True])
def test_depth_and_picture_lie_where_vtk_draws_them(pyvista: Any, plotter: Any, parallel: bool) -> None:
    plotter.add_mesh(pyvista.Cone(center=(0.3, 0, 0.5), direction=(0, 0, 1)), color="tan")
    actor = plotter.add_mesh(pyvista.Cube().triangulate(), color="white")
    actor.position, actor.orientation, actor.scale = (-0.4, 0.2, -0.3), (10, 20, 30), (1, 0.8, 0.6)
    plotter.camera_position = [(3, -4, 2.5), (0, 0, 0), (0, 0, 1)]
    plotter.camera.parallel_projection = parallel
    plotter.render_window.SetMultiSamples(0)
    color = plotter.screenshot(return_img=True)
    depth = plotter.get_image_depth()
    if not np.isfinite(depth).any():
        pytest.skip("VTK draws nothing here")
    drawn = ao.render(plotter, size=SIZE, aovs=("depth", "color"))
    both = np.isfinite(depth) & (drawn.depth > 0)
    assert 0.99 < both.sum() / np.isfinite(depth).sum() <= 1 and (drawn.depth > 0).sum() <= 1.01 * both.sum()
    assert np.median(np.abs(drawn.depth + depth)[both]) < 2e-3
    visibility = ao.occlusion(depth, plotter, depth_kind="vtk", method=ao.Bitmask(radius=0.5))
    assert visibility.shape == color.shape[:2] and 0 < visibility.min() < 0.9 and (visibility[~np.isfinite(depth)] == 1).all()


def test_the_view_that_show_would_start_with(pyvista: Any, plotter: Any) -> None:
    plotter.add_mesh(pyvista.Sphere(center=(5, 0, 0)))
    scene = ao.from_pyvista(plotter)
    plotter.render()
    plotter.screenshot(return_img=True)
    np.testing.assert_allclose(scene.cameras[0].pose, as_camera(plotter).pose, atol=1e-6)
