"""Spheres as arrays: what they may be, and their boxes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.scene.model import Scene
from ssao_gl.scene.spheres import Spheres

from ..shapes import quad

TURN = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])


def test_bounds_hold_every_sphere_and_no_more() -> None:
    scaled = TURN @ np.diag([2, 2, 2, 1.0])
    scaled[:3, 3] = (4, 5, 6)
    points, radii = np.array([[0, 0, 0], [3, 1, 0]], np.float32), np.array([1, 0.5], np.float32)
    spheres = Spheres(points, radii, transforms=np.stack([np.eye(4), scaled]))
    boxes = [
        (c - s * r, c + s * r)
        for m, s in ((np.eye(4), 1), (scaled, 2))
        for c, r in zip(points @ m[:3, :3].T + m[:3, 3], radii, strict=True)
    ]
    expected = np.array([np.min([low for low, _ in boxes], 0), np.max([high for _, high in boxes], 0)])
    np.testing.assert_allclose(spheres.bounds, expected, atol=1e-5)


def test_far_spheres_keep_their_place() -> None:
    far = Spheres.from_points([[1e8, 0, 0], [1e8 + 1.5, 0, 0]], 0.25)
    np.testing.assert_allclose(far.bounds[:, 0] - 1e8, [-0.25, 1.75], atol=1e-6)


def test_a_scene_of_all_kinds_is_one_scene() -> None:
    scene = Scene([quad((0, -1, 0), (2, 0, 0), (0, 0, 2))], spheres=[Spheres(np.zeros((1, 3)), np.ones(1))])
    np.testing.assert_allclose(scene.bounds, [[-2, -1, -2], [2, 1, 2]])
    assert scene.contents == "2 triangles, 1 spheres" and scene.pieces == 3
    with pytest.raises(ao.SceneError, match="nothing to draw"):
        Scene()
    with pytest.raises(ao.SceneError, match="nothing to draw"):
        Scene(spheres=[Spheres(np.zeros((0, 3)), np.zeros(0))])


def test_a_stray_atom_moves_no_camera() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(12.0)] * 3), -1).reshape(-1, 3)
    plain, stray = (Scene(spheres=[Spheres(points, 1.0)]) for points in (grid, np.vstack([grid, [[4000, 0, 0]]])))  # type: ignore[arg-type]
    assert stray.default_radius() == pytest.approx(plain.default_radius(), rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"centers": np.zeros((2, 2))}, r"centers must be \(n, 3\), got \(2, 2\)"),
        ({"centers": np.array([[0, np.nan, 0], [0, 0, 0]])}, "1 centers are not finite"),
        ({"radii": np.array([1.0, -1])}, "1 radii are negative or not finite"),
        ({"radii": np.array([np.inf, 1])}, "1 radii are negative or not finite"),
        ({"radii": np.ones(3)}, r"radii must be one number or \(2,\)"),
        ({"colors": np.zeros((2, 3), np.uint8)}, r"colors must be \(2, 4\) uint8"),
        ({"transforms": np.eye(4)}, r"transforms must be finite and \(k, 4, 4\)"),
        ({"transforms": np.diag([1, 2, 1, 1.0])[None]}, "transform 0 is no turn with a uniform scale"),
        ({"transforms": np.zeros((1, 4, 4))}, "transform 0 is no turn"),
    ],
)
def test_bad_input(arguments: dict[str, np.ndarray], told: str) -> None:
    with pytest.raises(ao.SceneError, match=told):
        Spheres(**({"centers": np.zeros((2, 3)), "radii": np.ones(2)} | arguments))
