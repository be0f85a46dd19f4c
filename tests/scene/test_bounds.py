"""Boxes of what is drawn: exact, and without strays."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from ssao_gl.scene.model import Mesh, Scene

BALL = trimesh.creation.icosphere(4)
P, T = BALL.vertices.astype(np.float32), BALL.faces.astype(np.uint32)


def test_bounds_of_turned_nodes_are_those_of_their_vertices() -> None:
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    turn[:3, 3] = (4, 5, 6)
    mesh = Mesh(P, T, transforms=np.stack([turn, np.eye(4)]))
    world = np.concatenate([P @ m[:3, :3].T + m[:3, 3] for m in mesh.transforms])
    np.testing.assert_allclose(mesh.bounds, [world.min(0), world.max(0)], atol=1e-6)
    baked = Scene.from_arrays(P @ turn[:3, :3].T + turn[:3, 3], T)
    np.testing.assert_allclose(Scene([Mesh(P, T, transforms=turn[None])]).default_radius(), baked.default_radius(), rtol=1e-4)


def test_vertices_that_nothing_names_do_not_count() -> None:
    stray = Scene.from_arrays(np.vstack([P, [[1e6, 0, 0]]]), T)
    plain = Scene.from_arrays(P, T)
    np.testing.assert_array_equal(stray.bounds, plain.bounds)
    np.testing.assert_array_equal(stray.default_camera().pose, plain.default_camera().pose)


@pytest.mark.parametrize("distance", [1.2, 2.0, 10.0, 1e3, 1e6])
@pytest.mark.parametrize("side", [1, -1])
def test_a_tiny_far_triangle_moves_no_camera_and_no_radius(distance: float, side: int) -> None:
    corners = side * distance * np.array([1, 0.3, 0]) + np.array([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0.01]])
    stray = Scene.from_arrays(np.vstack([P, corners]), np.vstack([T, [[len(P), len(P) + 1, len(P) + 2]]]))
    plain = Scene.from_arrays(P, T)
    assert stray.default_radius() == pytest.approx(plain.default_radius(), rel=0.01)
    np.testing.assert_allclose(stray.default_camera().pose, plain.default_camera().pose, atol=0.01)
    assert stray.bounds[1 if side > 0 else 0, 0] * side >= distance - 1e-3, "all that is drawn is within the box"


def test_things_apart_that_can_be_seen_stay() -> None:
    two = Scene([Mesh(P, T), Mesh(P * 0.1, T, transforms=trimesh.transformations.translation_matrix([9, 0, 0])[None])])
    np.testing.assert_array_equal(two.core, two.bounds)
