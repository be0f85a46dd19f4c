"""Sample kernels and rotation tiles: in the disk, seeded, spread evenly. No OpenGL."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from ssao_gl.errors import SettingsError
from ssao_gl.sampling.disk import Kernel, Rotation, bayer, radical_inverse

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


KERNELS = st.builds(
    Kernel,
    count=st.integers(1, 256),
    distribution=st.sampled_from(["spiral", "hammersley", "uniform"]),
    seed=st.integers(0, 2**31 - 1),
)


@given(KERNELS)
def test_kernels_are_in_the_disk_and_repeat(kernel: Kernel) -> None:
    points = kernel.points()
    assert points.shape == (kernel.count, 2) and points.dtype == np.float32
    assert np.linalg.norm(points.astype(np.float64), axis=1).max() < 1
    np.testing.assert_array_equal(points, dataclasses.replace(kernel).points())


@given(st.integers(1, 256), st.sampled_from(["spiral", "hammersley"]))
def test_points_have_equal_weight(count: int, distribution: str) -> None:
    """The disk is cut into ``count`` rings of equal area with a point in each: any mean over rings is right to 1/n, and the
    weights of Monte Carlo integration, 1/n each, sum to one."""
    area = np.sort((Kernel(count=count, distribution=distribution).points().astype(np.float64) ** 2).sum(1))
    np.testing.assert_allclose(area, (np.arange(count) + 0.5) / count, atol=1e-6)
    assert area.mean() == pytest.approx(0.5, abs=1e-6)


@given(st.integers(16, 256), st.sampled_from(["spiral", "hammersley"]))
def test_points_are_of_low_discrepancy(count: int, distribution: str) -> None:
    """Of the disk unrolled area for area: at most as that of the Hammersley set, (log2 n + 3.5) / 2n in two dimensions
    (Niederreiter 1992, theorem 3.8), and far below what random points have."""
    points = Kernel(count=count, distribution=distribution).points().astype(np.float64)
    square = np.column_stack([(points**2).sum(1), np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) % 1])
    bound = (math.log2(count) + 3.5) / (2 * count)
    assert star_discrepancy(square) <= bound
    random = [qmc.discrepancy(np.random.default_rng(s).random((count, 2)), method="L2-star") for s in range(9)]
    assert qmc.discrepancy(square.clip(0, 1), method="L2-star") < 0.9 * np.median(random)


def star_discrepancy(points: np.ndarray) -> float:
    """The largest difference between the share of points in a box at the origin and its area (exact, O(n^2))."""
    n, worst = len(points), 0.0
    corners = np.concatenate([points, [[1, 1]]])
    for x in corners[:, 0]:
        inside = points[points[:, 0] <= x]
        strictly = points[points[:, 0] < x]
        for y in (corners[:, 1],):
            closed = (inside[:, 1][None] <= y[:, None]).sum(1) / n
            open_ = (strictly[:, 1][None] < y[:, None]).sum(1) / n
            worst = max(worst, (closed - x * y).max(), (x * y - open_).max())
    return worst


@given(st.integers(1, 64), st.sampled_from(["stratified", "random"]), st.integers(0, 2**31 - 1))
def test_rotations_of_any_seed_are_unit_vectors(tile: int, distribution: str, seed: int) -> None:
    rotation = Rotation(tile=tile, distribution=distribution, seed=seed)
    vectors = rotation.vectors()
    assert vectors.shape == (tile, tile, 2) and vectors.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(vectors.astype(np.float64), axis=-1), 1, atol=1e-6)
    np.testing.assert_array_equal(vectors, dataclasses.replace(rotation).vectors())


@given(st.integers(1, 64), st.integers(0, 2**31 - 1))
def test_stratified_rotations_are_even(tile: int, seed: int) -> None:
    """Reflections at them turn a tap through the full circle in equal steps."""
    vectors = Rotation(tile=tile, seed=seed).vectors().astype(np.float64).reshape(-1, 2)
    turns = np.sort(2 * np.arctan2(vectors[:, 1], vectors[:, 0]) / (2 * np.pi) % 1)
    np.testing.assert_allclose(turns, (np.arange(tile * tile) + 0.5) / tile**2, atol=1e-6)


@given(st.integers(0, 6))
def test_bayer_is_a_permutation(power: int) -> None:
    assert sorted(bayer(2**power)) == list(range(4**power))


@given(st.integers(0, 2**52 - 1))
def test_radical_inverse_mirrors_the_bits(index: int) -> None:
    value = radical_inverse(index)
    assert 0 <= value < 1
    bits = f"{index:b}"[::-1]
    assert value == int(bits, 2) / 2 ** len(bits)
