"""The filters against their formulas in numpy, and what they must never do."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import NORMAL, NORMAL_SMALL, VISIBILITY_RAW
from ssao_gl.passes.denoise import FILTERS, FilterJob, gaussian, matched
from ssao_gl.passes.resolution import EDGE
from ssao_gl.scene.model import Scene

from ..conftest import openable
from ..shapes import camera, quad
from .noise import AWAY, LENSES, SMALL, ball, decoded, noise_through, points, tolerance, unpacked, visibility

SIZE = (160, 120)


def both(renderer: ao.Renderer, scene: Scene, cam: ao.Camera, blur: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Raw and filtered visibility, and depth."""
    method = ao.Alchemy(radius=0.7, samples=4)
    raw, filtered = (
        renderer.render(
            scene, cam, SIZE, ao.Settings(method=method, blur=b), aovs=("visibility", "depth"), visibility_bits=8, checked=True
        )  # type: ignore[arg-type]
        for b in (None, blur)
    )
    return raw.visibility, filtered.visibility, raw.depth


def bilateral(
    v: np.ndarray, depth: np.ndarray, blur: ao.LectureBlur | ao.Separable, axes: tuple[int, int] = (1, 1)
) -> np.ndarray:
    """The lecture's formula in float64, background left out; over a square, or along one axis (x, y)."""
    h, w = v.shape
    total, norm = np.zeros_like(v, np.float64), np.zeros_like(v, np.float64)
    g = gaussian(blur.radius, blur.sigma_space).astype(np.float64)
    for dy in range(-blur.radius * axes[1], blur.radius * axes[1] + 1):
        for dx in range(-blur.radius * axes[0], blur.radius * axes[0] + 1):
            y, x = np.clip(np.arange(h) + dy, 0, h - 1), np.clip(np.arange(w) + dx, 0, w - 1)
            q, z = v[y][:, x], depth[y][:, x]
            weight = g[abs(dx)] * g[abs(dy)] * np.exp(-0.5 * ((q - v) / blur.sigma_range) ** 2) * (z > 0)
            total += weight * q
            norm += weight
    return np.where(depth > 0, total / np.maximum(norm, 1e-12), 1.0)


def test_the_lecture_filter_is_its_formula(renderer: ao.Renderer, embedded: Scene) -> None:
    blur = ao.LectureBlur(radius=3)
    raw, filtered, depth = both(renderer, embedded, embedded.cameras[0], blur)
    expected = bilateral(np.round(raw * 255) / 255, depth, blur)
    assert np.abs(filtered - expected).max() <= 1.01 / 255


def test_separable_is_its_formula_along_either_axis(renderer: ao.Renderer, embedded: Scene) -> None:
    blur = ao.Separable(radius=3)
    raw, filtered, depth = both(renderer, embedded, embedded.cameras[0], blur)
    along_x = np.round(bilateral(np.round(raw * 255) / 255, depth, blur, (1, 0)) * 255) / 255
    assert np.abs(filtered - bilateral(along_x, depth, blur, (0, 1))).max() <= 2.01 / 255  # where a half is rounded otherwise
    assert np.abs(filtered - bilateral(along_x, depth, blur, (0, 1))).mean() <= 0.3 / 255


def test_separable_is_close_to_the_full_filter(renderer: ao.Renderer, embedded: Scene) -> None:
    _, full, _ = both(renderer, embedded, embedded.cameras[0], ao.LectureBlur(radius=3))
    _, separable, _ = both(renderer, embedded, embedded.cameras[0], ao.Separable(radius=3))
    assert np.abs(full - separable).mean() < 4 / 255


@pytest.mark.parametrize("kind", FILTERS)
def test_background_never_mixes_in(renderer: ao.Renderer, kind: str) -> None:
    """A dark slot before open sky stays as dark at its rim as the raw values around it are."""
    raw, filtered, depth = both(renderer, CROSS, camera(), FILTERS[kind]())
    sky = depth == 0
    assert 0.2 < sky.mean() < 0.9 and (filtered[sky] == 1).all()
    high, low = neighbourhood(raw, depth, FILTERS[kind]().radius or 2)
    seen = ~sky
    assert (filtered[seen] <= high[seen] + 2.01 / 255).all() and (filtered[seen] >= low[seen] - 2.01 / 255).all()


def neighbourhood(v: np.ndarray, depth: np.ndarray, radius: int) -> tuple[np.ndarray, np.ndarray]:
    """Largest and smallest value of the surface pixels in the window of the filter."""
    h, w = v.shape
    high, low = np.zeros_like(v), np.ones_like(v)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            y, x = np.clip(np.arange(h) + dy, 0, h - 1), np.clip(np.arange(w) + dx, 0, w - 1)
            q, seen = v[y][:, x], depth[y][:, x] > 0
            high, low = np.where(seen, np.maximum(high, q), high), np.where(seen, np.minimum(low, q), low)
    return high, low


CROSS = Scene([
    quad((0, 0, -5), (1.8, 0, 0), (0, 1.2, 0)),
    quad((0, 0, -4.7), (0.4, 0, 0.4), (0, 1.2, 0)),
    quad((0, 1.2, -4.8), (1.8, 0, 0), (0, 0, 0.3)),
])  # fmt: skip


def test_joint_keeps_an_edge_in_depth(renderer: ao.Renderer) -> None:
    """A dark corner behind, an open card in front: the card stays open up to its edge."""
    card = quad((0.6, 0, -3), (0.6, 0, 0), (0, 3, 0))
    room = [quad((0, 0, -6), (6, 0, 0), (0, 6, 0)), quad((0.0, 0, -5), (0, 0, 1), (0, 6, 0))]
    raw, filtered, depth = both(renderer, Scene([*room, card]), camera(), ao.Joint())
    front = (depth > 0) & (depth < 3.5)
    assert front.sum() > 100
    assert np.abs(filtered[front] - raw[front].mean()).max() <= np.abs(raw[front] - raw[front].mean()).max() + 1.01 / 255
    assert filtered[front].min() >= raw[front].min() - 1.01 / 255


def test_joint_removes_the_noise_of_its_tile(renderer: ao.Renderer) -> None:
    """Along the corner of two walls nothing changes, so what does is noise: below half a code after the filter."""
    from ..shapes import corner

    raw, filtered, _ = both(renderer, corner(), ao.Camera.orthographic(3.0, 0, 40.0), ao.Joint())
    assert raw[36:84].std(0).max() > 4 / 255
    assert filtered[36:84].std(0).max() < 0.75 / 255


def test_weights() -> None:
    np.testing.assert_allclose(gaussian(2, 1.0), [1, np.exp(-0.5), np.exp(-2)], rtol=1e-6)
    tile = np.zeros(4)
    for offset, weight in zip(range(-2, 3), np.concatenate([matched(2)[:0:-1], matched(2)]), strict=True):
        tile[offset % 4] += weight
    np.testing.assert_allclose(tile, 1)


def test_radius_1_and_wide_filters_compile(renderer: ao.Renderer, embedded: Scene) -> None:
    for blur in (ao.Joint(radius=1), ao.Joint(radius=16, sigma=5), ao.Separable(radius=32), ao.LectureBlur(radius=8)):
        _, filtered, _ = both(renderer, embedded, embedded.cameras[0], blur)
        assert np.isfinite(filtered).all()


def smooth(z: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Which texels have a surface and no edge of depth in the square that the filter reaches, and one texel more."""
    flat = z > 0
    for step, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
        flat &= np.abs(z - np.roll(z, step, axis)) < edge
    there = np.ones_like(flat)
    there[:3] = there[-3:] = there[:, :3] = there[:, -3:] = False
    for dy, dx in itertools.product(range(-2, 3), repeat=2):
        there &= np.roll(flat, (dy, dx), (0, 1))
    return there


@pytest.mark.gl
@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("tilt", [0.0, 0.9, 1.2])
@pytest.mark.parametrize("lens", LENSES)
def test_joint_removes_the_noise_of_its_tile_from_any_plane(lens: str, tilt: float, scale: int) -> None:
    """However it is tilted and seen, and at every size: each tap lies in the plane of the pixel, and counts in full."""
    view = LENSES[lens].view(SMALL)
    for turn in (0.0, 0.7, 1.6):
        spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        u, v = spin @ [19, 0, 0], spin @ [0, 19 * np.cos(tilt), 19 * np.sin(tilt)]
        found, _, z, _ = filtered(lens, Scene([quad((0, 0, -AWAY), tuple(u), tuple(v))]), scale)
        # Where depth is steeper, downsampling takes pixels in turns.
        edge = (0.9 * EDGE * scale / (scale - 1) if scale > 1 else 1e3) * view.pixel
        there = smooth(z, edge * (view.w1 * z + view.w0))
        assert there.sum() > 60 / scale, turn
        assert np.abs(found[there] - 0.5).max() <= 1.5 / 255 + 1e-6, turn


def joint(v: np.ndarray, z: np.ndarray, n: np.ndarray, cam: ao.Camera, scale: int, axis: int) -> np.ndarray:
    """One axis of the filter from its definition: a tap weighs by its distance from the pixel's tangent plane.

    As far as some tap does not lie in it, the filter is the one of half the width.
    """
    places, size = points(z, cam, scale), tolerance(z, cam, ao.Joint().tolerance, scale)
    sums = {width: [v.copy(), np.ones_like(v)] for width in (2, 1)}
    least = np.ones_like(v)
    for i in (-2, -1, 1, 2):
        q, tap, there = (np.roll(a, -i, 1 - axis) for a in (places, v, z > 0))
        fits = np.clip(2 - np.abs((n * (q - places)).sum(-1)) / size, 0, 1) * there
        least = np.minimum(least, fits)
        for width, total in sums.items():
            weight = matched(width)[abs(i)] if abs(i) <= width else 0
            total[0], total[1] = total[0] + weight * fits * tap, total[1] + weight * fits
    least = np.minimum(2 * least, 1)
    found = [least * wide + (1 - least) * narrow for wide, narrow in zip(sums[2], sums[1], strict=True)]
    return np.round(found[0] / found[1] * 255) / 255


def filtered(lens: str, scene: Scene, scale: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of each texel: a noise after the joint filter and before, depth, normal."""
    job = FilterJob(tile=4, scale=scale)
    seen = noise_through(openable()[0], ao.Joint().passes(job), [job.result], scene, LENSES[lens], scale)
    raw, z = unpacked(seen[VISIBILITY_RAW][..., 0])
    return visibility(seen[job.result]), raw, z, decoded(seen[NORMAL if scale == 1 else NORMAL_SMALL])


@pytest.mark.gl
@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("lens", LENSES)
def test_joint_is_its_formula(lens: str, scale: int) -> None:
    """On a ball, whose taps lie off the tangent plane by more and less than the tolerance."""
    found, raw, z, n = filtered(lens, ball(lens), scale)
    expected = joint(joint(raw, z, n, LENSES[lens], scale, 0), z, n, LENSES[lens], scale, 1)
    inner = z > 0
    inner[:2] = inner[-2:] = inner[:, :2] = inner[:, -2:] = False
    assert inner.sum() > 100 / scale and np.abs(found - 0.5)[inner].max() > 0.05, "the tolerance was felt"
    assert np.abs(found - expected)[inner].max() <= 1.01 / 255
