"""What the report draws with: filters over a given visibility, and images moved by whole pixels."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.experiment.error_split import shifted
from ssao_gl.passes.denoise import FILTERS
from ssao_gl.scene.model import Scene

SIZE = (96, 64)


@pytest.mark.parametrize("kind", FILTERS)
def test_a_given_visibility_is_filtered_as_a_method_s_own(renderer: ao.Renderer, embedded: Scene, kind: str) -> None:
    camera, method = embedded.cameras[0], ao.Alchemy(radius=0.5, samples=4)
    raw, own = (
        renderer.render(
            embedded, camera, SIZE, ao.Settings(method=method, blur=blur), aovs=("visibility",), visibility_bits=8
        ).visibility
        for blur in (None, FILTERS[kind]())
    )
    given, times = renderer.filter(embedded, camera, SIZE, raw, FILTERS[kind]())
    assert np.abs(given - own).max() <= 1.01 / 255
    assert [time.name for time in times][:2] == ["gbuffer", "pack"]


def test_a_shifted_camera_moves_the_image_by_whole_pixels(any_renderer: ao.Renderer, embedded: Scene) -> None:
    camera = embedded.cameras[0]
    still, moved = (
        any_renderer.render(embedded, one, SIZE, aovs=("depth",)).depth for one in (camera, shifted(camera, SIZE, 3, 2))
    )
    same = np.abs(moved[:-2, 3:] - still[2:, :-3]) <= 1e-4 * still[2:, :-3]
    assert same.mean() > 0.995  # pixel centres on an edge may fall to either side


def test_plans_that_are_kept_give_the_same_pictures(any_renderer: ao.Renderer, embedded: Scene) -> None:
    settings = [
        ao.Settings(method=m, blur=b)
        for m in (ao.Alchemy(samples=4), ao.Alchemy(samples=8), ao.Lecture())
        for b in (None, ao.Joint())
    ]
    with ao.Renderer(any_renderer.ctx.provider, keep=3) as keeping:
        for _ in range(2):
            for one in settings:
                expected, kept = (r.render(embedded, None, SIZE, one).visibility for r in (any_renderer, keeping))
                np.testing.assert_array_equal(kept, expected)
