"""The exhaustive reference against closed forms, where one layer of depth shows all that blocks."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.methods.reference import Reference
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.pose import look_at
from ssao_gl.truth.closed_forms import ClosedForm, closed_forms

WITHIN = 0.01

SIZES = {"plane": (64, 48), "wall": (320, 240), "well": (240, 180), "bowl": (480, 360), "trench": (480, 480)}
WIDE = Camera.perspective(0.65, 0.1, 100.0, look_at((5, 4.6, 0), (0.4, 0.4, 0)))
"""It sees more than a radius around floor and wall."""
DEEP = Camera.perspective(2.0, 0.1, 100.0, look_at((0, 4, 0), (0, 0, 0), (0, 0, -1)))
"""From close above and very wide: it sees the whole length of the trench, and its sides over many pixels."""


def errors(renderer: ao.Renderer, form: ClosedForm, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Reference minus closed form at every pixel (nan where there is none), and the world points of the pixels."""
    size = SIZES[form.name]
    method = Reference(radius=form.radius, thickness=None, slices=32)
    settings = ao.Settings(method=method, blur=None)
    picture = renderer.render(form.scene, camera, size, settings, aovs=("visibility", "depth"), checked=True)
    points = camera.view(size).points(picture.depth) @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    expected = form.visibility(points.reshape(-1, 3)).reshape(picture.depth.shape)
    return np.where(picture.depth > 0, picture.visibility - expected, np.nan), points


@pytest.mark.parametrize("name", ["plane", "well", "bowl"])
def test_where_all_blockers_are_in_the_image(any_renderer: ao.Renderer, name: str) -> None:
    form = closed_forms()[name]
    off, _ = errors(any_renderer, form, form.camera)
    assert np.isfinite(off).sum() > 1000
    assert np.nanmax(np.abs(off)) <= WITHIN


def test_wall_within_a_hard_radius(any_renderer: ao.Renderer) -> None:
    """Over all distances; without the pixels whose radius leaves the image, and the few that touch the crease."""
    form = closed_forms()["wall"]
    off, points = errors(any_renderer, form, WIDE)
    h, w = off.shape
    view = WIDE.view((w, h))
    z = (WIDE.pose[:3, 3] - points) @ WIDE.pose[:3, 2]
    reach = form.radius / (view.pixel * np.maximum(z - form.radius, 0.1))
    y, x = np.mgrid[:h, :w]
    inside = np.minimum(np.minimum(x, w - x), np.minimum(y, h - y)) > reach
    from_crease = points[..., :2].max(-1) / (view.pixel * z)
    seen = inside & (from_crease > 4) & np.isfinite(off)
    assert seen.sum() > 1000 and np.ptp(points[..., :2].max(-1)[seen]) > 0.9 * form.radius
    assert np.abs(off[seen]).max() <= WITHIN


def test_the_middle_of_a_trench(any_renderer: ao.Renderer) -> None:
    off, points = errors(any_renderer, closed_forms()["trench"], DEEP)
    middle = np.isfinite(off) & (np.abs(points[..., 2]) < 1)
    assert middle.sum() > 1000
    assert np.abs(off[middle]).max() <= WITHIN
