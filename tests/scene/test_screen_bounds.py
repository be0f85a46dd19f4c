"""Tests of ``scene/screen_bounds.py``: the image of a box, and a pixel around it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ssao_gl.scene.camera import Camera
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.screen_bounds import screen_bounds

SIZE = (64, 48)
EYE = (3.0, 2.0, 8.0)
CAMERAS = {
    "perspective": Camera.perspective(0.9, 0.1, 100.0, look_at(EYE, (0, 0, 0))),
    "parallel": Camera.orthographic(6.0, 0.0, 40.0, look_at(EYE, (0, 0, 0))),
}
places = st.tuples(*[st.floats(-3, 3)] * 3)
sides = st.tuples(*[st.floats(0, 2)] * 3)


def image(bounds: np.ndarray, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest place, in pixels from the lower left, of the corners of a box."""
    corners = np.array([[*corner, 1.0] for corner in itertools.product(*bounds.T)])
    clip = corners @ np.linalg.inv(camera.pose).T @ camera.view(SIZE).projection.T
    at = (0.5 + 0.5 * clip[:, :2] / clip[:, 3:]) * SIZE
    return at.min(0), at.max(0)


@pytest.mark.parametrize("kind", CAMERAS)
@given(place=places, side=sides)
def test_a_pixel_around_the_image_of_a_box(kind: str, place: tuple[float, ...], side: tuple[float, ...]) -> None:
    """On each of the four sides between one and two pixels, or up to the border of the image."""
    bounds = np.array([place, np.add(place, side)])
    low, high = image(bounds, CAMERAS[kind])
    assume((np.abs(low - np.round(low)) > 1e-6).all() and (np.abs(high - np.round(high)) > 1e-6).all())
    found = screen_bounds(bounds, CAMERAS[kind], CAMERAS[kind].view(SIZE))
    assert found is not None
    x, y, w, h = found
    assert (x, y) == tuple(np.clip(np.floor(low) - 1, 0, SIZE))
    assert (x + w, y + h) == tuple(np.maximum(np.clip(np.ceil(high) + 1, 0, SIZE), (x, y)))


@pytest.mark.parametrize("kind", CAMERAS)
def test_a_box_out_of_sight_takes_no_pixel(kind: str) -> None:
    bounds = np.array([[-50.0, 0, 0], [-49.0, 1, 1]])
    x, y, w, h = screen_bounds(bounds, CAMERAS[kind], CAMERAS[kind].view(SIZE)) or (0, 0, 1, 1)
    assert w * h == 0 and 0 <= x <= SIZE[0] and 0 <= y <= SIZE[1]


def test_a_box_about_the_viewer_may_be_anywhere() -> None:
    camera = CAMERAS["perspective"]
    assert screen_bounds(np.array([np.subtract(EYE, 1), np.add(EYE, 1)]), camera, camera.view(SIZE)) is None


def test_far_from_the_origin_the_box_is_where_it_was() -> None:
    shift = np.array([1e7, -3e6, 2e7])
    bounds = np.array([[-1.0, -1, -1], [1.0, 1, 1]])
    near = CAMERAS["perspective"]
    far = Camera.perspective(0.9, 0.1, 100.0, look_at(shift + EYE, shift))
    found = [screen_bounds(b, c, c.view(SIZE)) for b, c in ((bounds, near), (bounds + shift, far))]
    assert found[0] == found[1]
