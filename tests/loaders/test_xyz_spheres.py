"""XYZ files of atoms and of points with radii."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao


def test_atoms_by_element(tmp_path: Path) -> None:
    path = tmp_path / "water.xyz"
    path.write_text("3\na comment\nO 1000000.0 0 0\nh 1000000.96 0 0\nH -0.24 0.93 0\n2\nnext frame\nC 0 0 0\nC 1 0 0\n")
    (found,) = ao.load_scene(path).spheres
    np.testing.assert_allclose(found.radii, [1.52, 1.10, 1.10], rtol=1e-6)
    world = found.centers.astype(np.float64) + found.transforms[0, :3, 3]
    np.testing.assert_allclose(world[0], [1e6, 0, 0], atol=0.04)
    assert found.colors is not None and found.colors[0].tolist() == [255, 13, 13, 255]


def test_points_with_radii_and_without(tmp_path: Path) -> None:
    path = tmp_path / "points.xyz"
    path.write_text("# x y z r\n0 0 0 1\n4 0 0 0.5\n")
    (found,) = ao.load_scene(path).spheres
    assert found.radii.tolist() == [1, 0.5]
    np.testing.assert_allclose(found.bounds, [[-1, -1, -1], [4.5, 1, 1]])
    path.write_text("0 0 0\n4 0 0\n0 4 0\n")
    assert not ao.load_scene(path).spheres


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("3\n\nO 0 0 0\n", "announces 3 atoms, but has 1"),
        ("1\n\nO 0 zero 0\n", "line 3: 'O 0 zero 0'; expected 3 numbers"),
        ("0 0 0 1\n1 0 0\n", "line 2: '1 0 0'; expected 4 numbers"),
        ("0 0 0 -1\n", "1 radii are negative"),
        ("0 nan 0 1\n", "not finite"),
    ],
)
def test_what_is_broken_is_told(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.xyz"
    path.write_text(text)
    with pytest.raises(ao.SceneError, match="broken.xyz: .*" + told):
        ao.load_scene(path)
