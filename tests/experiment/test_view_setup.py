"""A view made ready: its zones are those of the surface, wherever the camera stands."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.experiment.view_setup import ViewSetup
from ssao_gl.metrics.zones import ZONES
from ssao_gl.scene.model import Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.truth import Tracing
from tests.shapes import quad

pytest.importorskip("embreex")

SIZE = (64, 48)


def setup(renderer: ao.Renderer, scene: Scene, eye: tuple[float, float, float], spp: int = 4, radius: float = 0.2) -> ViewSetup:
    camera = ao.Camera.perspective(0.9, 0.05, 200.0, look_at(eye, (0, 0, 0), (0, 1, 0)))
    return ViewSetup(renderer, scene, camera, SIZE, Tracing(radius=radius, spp=spp), None)


@pytest.mark.parametrize("eye", [(8.0, 0.4, 0.0), (-3.0, 0.3, 7.0), (0.1, 5.0, 0.1)])
def test_a_floor_is_flat_from_everywhere(renderer: ao.Renderer, eye: tuple[float, float, float]) -> None:
    found = setup(renderer, Scene([quad((0, 0, 0), (80, 0, 0), (0, 0, -80))]), eye)
    rows = found.depth.min(1) > 0
    assert rows.sum() > 10 and found.zones.seen[rows].all() and not found.zones.crease.any()
    assert found.zones.flat[rows][4:].all()  # but for the band at its horizon


def test_walls_meet_in_a_crease_and_end_in_an_edge(renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, 0), (2, 0, 0), (0, 0, -2)), quad((0, 0.8, -2), (2, 0, 0), (0, 0.8, 0))])
    found = setup(renderer, scene, (0, 3.0, 6.0), radius=2.0).zones
    middle = SIZE[0] // 2
    names = np.full(SIZE[::-1], "none", object)
    for name in ZONES:
        names[getattr(found, name)] = name
    column = names[:, middle]
    turns = [name for name, before in zip(column, [None, *column], strict=False) if name != before]
    assert [name for name in turns if name != "none"] == ["edge", "flat", "crease", "flat", "edge"]


def test_the_noise_of_a_single_batch_is_unknown(renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, 0), (80, 0, 0), (0, 0, -80))])
    known, unknown = (setup(renderer, scene, (0.1, 5.0, 0.1), spp) for spp in (4, 1))
    assert known.stderr is not None and unknown.stderr is None
    picture = np.full(SIZE[::-1], 0.9, np.float32)
    assert known.errors(picture)["rmse_net"] == pytest.approx(0.1, rel=1e-3) and np.isnan(unknown.errors(picture)["rmse_net"])
