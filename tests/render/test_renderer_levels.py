"""Visibility of arrays has the levels of half floats, that of pictures the 256 of 8 bits; work is the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import VISIBILITY
from ssao_gl.io.images import load_image
from ssao_gl.pipeline.build import plan_apply, plan_render
from ssao_gl.stress.analytic_depth import ball_depth, cast, flat

from ..command_line import run

SIZE = (160, 120)
CAMERA = ao.Camera.perspective(0.9, 0.1, 40)
DEPTH = cast(CAMERA, SIZE, flat((0, -0.5, 0), (0, 1, 0), within=6), ball_depth((0, -0.2, -2), 0.4)).astype(np.float32)
METHODS = [ao.Bitmask(radius=0.5), ao.Alchemy(radius=0.5)]
FILTERS = [None, ao.Joint(), ao.LectureBlur(), ao.Separable()]


@pytest.mark.parametrize("blur", FILTERS, ids=lambda b: b.name if b else "none")
@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_arrays_hold_more_than_256_levels(renderer: ao.Renderer, method: ao.Bitmask, blur: ao.Joint | None) -> None:
    settings = ao.Settings(method=method, blur=blur)
    fine, coarse = (
        renderer.apply(DEPTH, CAMERA, settings=settings, visibility_bits=bits, checked=True).visibility for bits in (16, 8)
    )
    limit = 40 if blur is None and method.name == "alchemy" else 256  # few samples a pixel have few values
    assert np.unique(fine).size > limit and np.unique(coarse).size <= 256
    assert fine.dtype == np.float32 and fine.min() >= 0 and fine.max() == 1 and (fine[DEPTH == 0] == 1).all()
    assert np.abs(fine - coarse).max() <= 0.75 / 255
    assert np.array_equal(fine, renderer.apply(DEPTH, CAMERA, settings=settings).visibility)


def test_scenes_too(any_renderer: ao.Renderer, embedded: ao.Scene) -> None:
    fine, coarse = (any_renderer.render(embedded, None, SIZE, visibility_bits=bits) for bits in (16, 8))
    assert np.unique(fine.visibility).size > 256 >= np.unique(coarse.visibility).size
    assert np.abs(fine.visibility - coarse.visibility).max() <= 0.75 / 255
    assert np.abs(fine.image.astype(int) - coarse.image).max() <= 1
    with pytest.raises(ao.SettingsError, match="visibility_bits=12: must be 8 or 16"):
        any_renderer.render(embedded, None, SIZE, visibility_bits=12)


def test_functions_for_people() -> None:
    assert np.unique(ao.occlusion(DEPTH, CAMERA, method=ao.Bitmask(radius=0.5))).size > 256


@pytest.mark.parametrize("scale", [1, 2])
def test_the_work_is_the_same(scale: int) -> None:
    """The same passes; only the texture that visibility ends in is another, a byte a pixel larger."""
    settings = ao.Settings(method=ao.Bitmask(radius=0.5, scale=scale))
    for plans in (
        [plan_render(settings, SIZE, ("visibility",), fine=fine) for fine in (True, False)],
        [plan_apply(settings, SIZE, fine=fine) for fine in (True, False)],
    ):
        fine, coarse = plans
        assert [step.task.name for step in fine.steps] == [step.task.name for step in coarse.steps]
        assert fine.bytes - coarse.bytes <= 2 * SIZE[0] * SIZE[1]
        changed = {
            (name, a.format, step.task.writes[name].format)
            for step, other in zip(fine.steps, coarse.steps, strict=True)
            for name, a in other.task.writes.items()
            if a != step.task.writes[name]
        }
        assert {entry[1:] for entry in changed} == {("r8", "r16f")} and VISIBILITY in {entry[0] for entry in changed}
    assert plan_render(settings, SIZE, ("image",)) == plan_render(settings, SIZE, ("image",), fine=False)


@pytest.mark.gl
def test_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "d.npy", DEPTH)
    words = ("apply", "--depth", tmp_path / "d.npy", "--yfov-deg", "51.5", "--radius", "0.5", "-o")
    levels = {}
    for name in ("v.npy", "v.exr", "v.png", "folder"):
        assert run(*words, tmp_path / name, capsys=capsys)[0] == 0
        at = tmp_path / name / "visibility.npy" if name == "folder" else tmp_path / name
        levels[name] = np.unique(load_image(at)).size
    assert levels["v.npy"] == levels["v.exr"] == levels["folder"] > 256 >= levels["v.png"]
    for name, bits in (("r.png", 8), ("r.png", 16)):
        words = ("render", "--size", "160x120", "--aov", "visibility", "--bits", bits, "-o", tmp_path / name)
        assert run(*words, capsys=capsys)[0] == 0
        assert (np.unique(load_image(tmp_path / name)).size > 256) == (bits == 16)
