"""What every AO method promises, on every provider. A new method is tested here because it is registered.

A method whose published definition breaks a promise declares it (``exceptions``), with a bound that is tested instead.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..shapes import camera, corner, moved, plane, scaled, spread, with_radius

SIZE = (96, 72)
STEP = 1 / 255 + 1e-6

METHODS = list(ao.registry())


def visibility(
    renderer: ao.Renderer,
    name: str,
    scene: Scene,
    cam: Camera,
    radius: float = 0.8,
    blur: object = None,
    size: tuple[int, int] = SIZE,
) -> np.ndarray:
    settings = ao.Settings(method=with_radius(ao.method(name), radius), blur=blur)  # type: ignore[arg-type]
    picture = renderer.render(scene, cam, size, settings, aovs=("visibility", "depth"), checked=True)
    seen = picture.visibility
    assert np.isfinite(seen).all() and seen.min() >= 0 and seen.max() <= 1
    assert (seen[picture.depth == 0] == 1).all()
    return seen


def bound(name: str, contract: str, default: float) -> float:
    declared = ao.registry()[name].exceptions.get(contract)  # type: ignore[attr-defined]
    return declared.bound if declared else default


@pytest.mark.parametrize("blur", [None, ao.Joint()], ids=["raw", "joint"])
@pytest.mark.parametrize("tilt", [0.0, 0.6, -1.2, 1.4])
@pytest.mark.parametrize("name", METHODS)
def test_a_plane_is_open(renderer: ao.Renderer, name: str, tilt: float, blur: object) -> None:
    seen = visibility(renderer, name, plane(tilt), camera(), blur=blur)
    assert 1 - seen.min() <= bound(name, "plane", STEP)


@pytest.mark.parametrize("name", METHODS)
def test_a_corner_is_darker_than_its_walls(renderer: ao.Renderer, name: str) -> None:
    seen = visibility(renderer, name, corner(), camera(), blur=ao.Joint()).mean(0)
    middle, walls = seen[44:52].mean(), np.concatenate([seen[:12], seen[-12:]]).mean()
    assert middle < walls - 0.1


@pytest.mark.parametrize("name", METHODS)
def test_no_radius_no_occlusion(renderer: ao.Renderer, name: str) -> None:
    method = dataclasses.replace(ao.method(name), radius=1e-6)
    settings = ao.Settings(method=method, blur=None)
    seen = renderer.render(corner(), camera(), SIZE, settings, aovs=("visibility",)).visibility
    assert 1 - seen.min() <= bound(name, "radius", STEP)


@pytest.mark.parametrize("name", METHODS)
def test_the_same_input_gives_the_same_bytes(renderer: ao.Renderer, name: str, embedded: Scene) -> None:
    first, second = (visibility(renderer, name, embedded, embedded.cameras[0], blur=ao.Joint()) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("name", METHODS)
def test_units_do_not_matter(renderer: ao.Renderer, name: str, embedded: Scene, factor: float) -> None:
    def shot(s: float) -> np.ndarray:
        lens = embedded.cameras[0].lens
        pose = embedded.cameras[0].pose.copy()
        pose[:3, 3] *= s
        cam = Camera.perspective(lens.yfov, lens.znear * s, lens.zfar * s, pose)  # type: ignore[attr-defined]
        return visibility(renderer, name, scaled(embedded, s), cam, 0.7 * s)

    off = np.abs(shot(1.0) - shot(factor)) > STEP
    assert off.mean() <= bound(name, "scale", 0.002 * spread(ao.method(name)))  # edges may round to the next pixel


@pytest.mark.parametrize("name", METHODS)
def test_the_place_in_the_world_does_not_matter(renderer: ao.Renderer, name: str, embedded: Scene) -> None:
    shift = np.eye(4)
    shift[:3, 3] = [1e7, -3e6, 2e7]
    here = visibility(renderer, name, embedded, embedded.cameras[0])
    far = moved(embedded, shift)
    assert (np.abs(here - visibility(renderer, name, far, far.cameras[0])) > STEP).mean() <= bound(
        name, "translation", 0.002 * spread(ao.method(name))
    )


@pytest.mark.parametrize("name", METHODS)
def test_the_far_plane_does_not_matter(renderer: ao.Renderer, name: str) -> None:
    near, far = (visibility(renderer, name, corner(), camera(zfar)) for zfar in (20.0, 200.0))
    assert np.abs(near - far).mean() <= bound(name, "far plane", 1e-4)


@pytest.mark.parametrize("name", METHODS)
def test_parallel_projection(renderer: ao.Renderer, name: str) -> None:
    parallel = Camera.orthographic(4.0, 0.0, 40.0)
    if math.isinf(bound(name, "orthographic", 0)):
        with pytest.raises(ao.SettingsError, match=name):
            visibility(renderer, name, corner(), parallel)
        return
    assert visibility(renderer, name, plane(0.7), parallel).min() >= 1 - bound(name, "plane", STEP)
    seen = visibility(renderer, name, corner(), parallel, blur=ao.Joint()).mean(0)
    assert seen[44:52].mean() < seen[:8].mean() - 0.1


@pytest.mark.parametrize("name", METHODS)
def test_an_off_centre_lens_shows_a_part_of_the_whole(renderer: ao.Renderer, name: str, embedded: Scene) -> None:
    """The left half of a wide image equals an image by a lens shifted to the left."""
    wide = embedded.cameras[0]
    m = wide.lens.matrix((192, 72))
    left = m.copy()
    left[0] = 2 * m[0] + m[3]  # x in -1..0 stretched to -1..1
    whole = visibility(renderer, name, embedded, wide, size=(192, 72))[:, :96]
    part = visibility(renderer, name, embedded, Camera.from_matrix(left, wide.pose))
    inner = slice(0, 96 - 24)  # away from the new border, beyond which taps are lost
    assert (np.abs(whole - part)[:, inner] > STEP).mean() <= bound(name, "border", 0.01)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (2, 2), (33, 17)])
@pytest.mark.parametrize("name", METHODS)
def test_any_size(renderer: ao.Renderer, name: str, size: tuple[int, int], embedded: Scene) -> None:
    assert visibility(renderer, name, embedded, embedded.cameras[0], blur=ao.Joint(), size=size).shape == size[::-1]


@pytest.mark.parametrize("max_radius", [256, 48])
def test_alchemy_is_calibrated_at_the_corner_of_two_walls(renderer: ao.Renderer, max_radius: float) -> None:
    """Seen along the bisector, a point in the corner is half occluded, also where the disk is clamped."""
    settings = ao.Settings(method=ao.Alchemy(radius=1.0, samples=64, bias=0.0, max_radius=max_radius))
    seen = renderer.render(corner(), camera(), (481, 360), settings, aovs=("visibility",)).visibility
    assert seen[150:210, 240].mean() == pytest.approx(0.5, abs=0.03)
