"""Tests of ``truth/surface.py``."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl import Camera, Scene
from ssao_gl.truth import Surface, Tracing, gather, surface
from ssao_gl.truth.closed_forms import closed_forms

from .test_trace import quad


def test_near_and_far_planes_cut() -> None:
    scene = Scene([quad((0, 0, -z), (9, 0, 0), (0, 9, 0)) for z in (1, 2, 3)])
    depths = {}
    for near, far in ((0.5, 9.0), (1.5, 9.0), (2.5, 9.0), (0.1, 0.9), (3.5, 9.0)):
        depths[near, far] = np.unique(surface(scene, Camera.perspective(1.0, near, far), (4, 4)).depth).tolist()
    assert list(depths.values()) == [[1.0], [2.0], [3.0], [0.0], [0.0]]


def test_shading_normals_are_used_when_asked_for(courtyard: Scene, seen: Surface) -> None:
    one, other = (gather(seen, Tracing(radius=0.7, spp=64, normals=n)) for n in ("geometric", "shading"))
    assert np.abs(one.visibility - other.visibility).max() > 0.01


@pytest.mark.parametrize("spp", [16, 128])
def test_standard_error_is_the_spread_over_seeds(spp: int) -> None:
    form = closed_forms()["trench"]
    found = surface(form.scene, form.camera, (24, 18))
    runs = [gather(found, Tracing(radius=form.radius, spp=spp, seed=seed)) for seed in range(48)]
    spread = np.sqrt(np.var([run.visibility[run.covered] for run in runs], axis=0, ddof=1).mean())
    said = np.sqrt(np.mean([run.noise**2 for run in runs]))
    assert said == pytest.approx(spread, rel=0.06)


def test_stratification_beats_plain_sampling(seen: Surface) -> None:
    found = gather(seen, Tracing(radius=0.7, spp=256))
    v = found.visibility[found.covered].astype(np.float64)
    assert found.noise < 0.65 * np.sqrt((v * (1 - v)).mean() / found.spp)


def test_max_stderr_stops_when_it_holds_and_at_spp(seen: Surface) -> None:
    limited = gather(seen, Tracing(radius=0.7, max_stderr=0.01))
    assert limited.noise <= 0.01 and 256 <= limited.spp < 4096
    capped = gather(seen, Tracing(radius=0.7, max_stderr=1e-5, spp=320))
    assert capped.noise > 1e-5 and capped.spp == 320


def test_one_ray_has_an_unknown_error(seen: Surface) -> None:
    found = gather(seen, Tracing(radius=0.7, spp=1))
    assert set(np.unique(found.visibility)) == {0.0, 1.0} and found.noise == 0.5
