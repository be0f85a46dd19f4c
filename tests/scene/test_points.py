"""Points drawn as discs."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import ssao_gl as ao


def test_a_floor_of_points_is_closed_and_open_to_the_sky(any_renderer: ao.Renderer) -> None:
    """Points at random on a plane: no holes, and no occlusion, as of the plane itself."""
    rng = np.random.default_rng(7)
    points = np.column_stack([rng.uniform(-1, 1, (4000, 2)), np.zeros(4000)])
    scene = ao.Scene.from_points(points)
    camera = ao.Camera.orthographic(1.6, 0.1, 10, ao.look_at((0, 0, 3), (0, 0, 0)))
    picture = any_renderer.render(scene, camera, (96, 96), aovs=("visibility", "depth"))
    covered = np.isfinite(picture.depth) & (picture.depth < 9)
    assert covered.mean() > 0.999
    assert picture.visibility[covered].mean() > 0.99


def test_discs_lie_along_the_surface() -> None:
    ball = trimesh.creation.icosphere(4)
    (mesh,) = ao.Scene.from_points(ball.vertices).meshes
    assert len(mesh.triangles) == 4 * len(ball.vertices) and mesh.normals is not None
    turned = np.abs(np.einsum("ij,ij->i", mesh.normals[::6], ball.vertices))
    assert turned.min() > 0.98
    reach = np.linalg.norm(mesh.positions.reshape(-1, 6, 3) - ball.vertices[:, None], axis=2)
    assert reach.max() < 0.3 and mesh.color == (0.8, 0.8, 0.8)


def test_radius_colours_and_broken_points() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [np.nan, 0, 0]])
    (mesh,) = ao.Scene.from_points(points, [[1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]], 0.25).meshes
    assert mesh.vertex_colors is not None and mesh.vertex_colors[::6].tolist() == [[255, 0, 0, 255], [0, 0, 255, 255]]
    np.testing.assert_allclose(np.linalg.norm(mesh.positions[:6] - mesh.positions[:6].mean(0), axis=1), 0.25, rtol=1e-5)
    assert len(ao.Scene.from_points([[1, 2, 3]]).meshes[0].triangles) == 4


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (([1, 2, 3],), r"must be \(n, 3\)"),
        (([[np.nan] * 3],), "none of the 1 positions is finite"),
        (([[0, 0, 0]], None, 0.0), "a radius of 0"),
        (([[0, 0, 0]], [[1, 1]]), r"colors must be \(1, 3 or 4\)"),
    ],
)
def test_what_is_no_cloud(arguments: tuple[object, ...], expected: str) -> None:
    with pytest.raises(ao.SceneError, match=expected):
        ao.Scene.from_points(*arguments)  # type: ignore[arg-type]


def test_an_array_of_points_is_a_scene() -> None:
    from ssao_gl.loaders.as_scene import as_scene

    assert as_scene(np.eye(3)).triangles == 12
    with pytest.raises(ao.SceneError, match=r"positions must be \(n, 3\), got \(4, 4\)"):
        as_scene(np.eye(4))


def test_points_at_one_place_are_one_place() -> None:
    """As many discs as points, each as its place alone has it; a hundred thousand at two places take no longer than others."""
    from ssao_gl.scene.points import surfels

    places = np.random.default_rng(8).normal(size=(40, 3))
    alone = surfels(places, None, None, None)
    doubled = surfels(np.concatenate([places, places[::-1]]), None, None, None)
    np.testing.assert_array_equal(doubled.positions[: 6 * 40], alone.positions)
    np.testing.assert_array_equal(doubled.positions[6 * 40 :].reshape(40, 6, 3)[::-1].reshape(-1, 3), alone.positions)
    many = surfels(np.tile([[0.0, 0, 0], [1, 0, 0]], (50_000, 1)), None, None, None)
    assert len(many.positions) == 600_000
