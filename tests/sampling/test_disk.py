"""Sample kernels and rotation tiles: in the disk, seeded, spread evenly. No OpenGL."""

import numpy as np
import pytest
from scipy.stats import qmc

from ssao_gl.errors import SettingsError
from ssao_gl.sampling.disk import Kernel, Rotation, radical_inverse

DISTRIBUTIONS = ("spiral", "hammersley", "uniform")


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
@pytest.mark.parametrize("count", [1, 4, 12, 64, 256])
def test_points_lie_in_the_unit_disk_and_repeat(distribution: str, count: int) -> None:
    points = Kernel(count=count, distribution=distribution, seed=3).points()
    assert points.shape == (count, 2) and points.dtype == np.float32
    assert np.linalg.norm(points, axis=1).max() < 1
    np.testing.assert_array_equal(points, Kernel(count=count, distribution=distribution, seed=3).points())


def square(points: np.ndarray) -> np.ndarray:
    """The disk unrolled to the unit square, area for area."""
    return np.column_stack([(points**2).sum(1).clip(0, 1 - 1e-7), np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) % 1])


@pytest.mark.parametrize("distribution", ["spiral", "hammersley"])
def test_low_discrepancy_beats_random_points(distribution: str) -> None:
    ours = qmc.discrepancy(square(Kernel(count=64, distribution=distribution).points()), method="L2-star")
    random = [qmc.discrepancy(np.random.default_rng(s).random((64, 2)), method="L2-star") for s in range(20)]
    assert ours < 0.5 * np.median(random)


def test_uniform_points_depend_on_the_seed() -> None:
    one, two = (Kernel(distribution="uniform", seed=s).points() for s in (0, 1))
    assert not np.array_equal(one, two)


@pytest.mark.parametrize("distribution", ["stratified", "random"])
@pytest.mark.parametrize("tile", [1, 3, 4, 8])
def test_rotations_are_unit_vectors(distribution: str, tile: int) -> None:
    vectors = Rotation(tile=tile, distribution=distribution).vectors()
    assert vectors.shape == (tile, tile, 2)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1, atol=1e-6)


def test_stratified_rotations_turn_a_tap_evenly_around_the_circle() -> None:
    vectors = Rotation(tile=4).vectors().reshape(-1, 2).astype(np.float64)
    tap = np.array([1.0, 0.0])
    turned = tap - 2 * (vectors @ tap)[:, None] * vectors
    angles = np.sort(np.arctan2(turned[:, 1], turned[:, 0]) % (2 * np.pi))
    np.testing.assert_allclose(np.diff(angles), 2 * np.pi / 16, atol=1e-6)


def test_radical_inverse() -> None:
    assert [radical_inverse(i) for i in range(5)] == [0, 0.5, 0.25, 0.75, 0.125]


@pytest.mark.parametrize("change", [{"count": 0}, {"count": 2.5}, {"count": 257}, {"distribution": "disk"}, {"seed": -1}])
def test_wrong_settings_are_named(change: dict[str, object]) -> None:
    with pytest.raises(SettingsError, match="kernel." + next(iter(change))):
        Kernel(**change)  # type: ignore[arg-type]
