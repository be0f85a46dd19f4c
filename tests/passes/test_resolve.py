"""Several samples a pixel: their means, coverage as alpha, one surface where a mean would lie on none, and nothing when it is off."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.model import Scene
from ssao_gl.scene.srgb import decode, encode
from ssao_gl.tiling.layout import layout, unguarded

from ..command_line import refused
from ..shapes import camera, quad

SIZE = (48, 36)
SLANTED = Scene([quad((0.1, 0, -4), (1, 0.35, 0), (-0.25, 0.7, 0))])
"""A sheet whose edges cut pixels at all angles, before nothing."""
STEPPED = Scene([*SLANTED.meshes, quad((0, 0, -6), (9, 0, 0), (0, 9, 1))])
"""The same before a tilted wall."""
PLAIN = ao.Bitmask(radius=0.5, guard=0.0)


def drawn(renderer: ao.Renderer, scene: Scene, many: int, size: tuple[int, int] = SIZE, **given: Any) -> ao.Picture:
    shading = ao.Shading(background=given.pop("background", "transparent"))
    settings = ao.Settings(method=given.pop("method", PLAIN), shading=shading, supersample=many)
    aovs = given.pop("aovs", "image,visibility,depth,normal,color,bent")
    return renderer.render(scene, camera(), size, settings, aovs=aovs, checked=True, **given)


def boxes(array: np.ndarray, many: int) -> np.ndarray:
    """The samples (h, w, many * many, ...) of each pixel of a larger picture."""
    h, w = array.shape[0] // many, array.shape[1] // many
    parts = array.reshape(h, many, w, many, *array.shape[2:])
    return np.moveaxis(parts, 1, 2).reshape(h, w, many * many, *array.shape[2:])


@pytest.mark.parametrize("many", [2, 3])
def test_pictures_are_means_and_surfaces_are_one_sample(any_renderer: ao.Renderer, many: int) -> None:
    """Of the picture that many times as large, whose occlusion is drawn as often."""
    large = tuple(many * side for side in SIZE)
    every = drawn(any_renderer, STEPPED, 1, large, method=dataclasses.replace(PLAIN, scale=4))
    found = drawn(any_renderer, STEPPED, many, method=dataclasses.replace(PLAIN, scale=4))
    assert found.image.shape == (*SIZE[::-1], 4)
    assert np.abs(found.visibility - boxes(every.visibility, many).mean(2)).max() <= 2**-11
    mean = encode(decode(boxes(every.image[..., :3], many) / 255).mean(2))
    assert np.abs(found.image[..., :3] / 255 - mean).max() <= 0.6 / 255
    depths = np.sort(boxes(every.depth, many), 2)
    assert (found.depth == depths[:, :, (many * many - 1) // 2]).all()
    which = np.argmax(boxes(every.depth, many) == found.depth[:, :, None], 2)
    for name in ("normal", "bent"):
        of_it = np.take_along_axis(boxes(getattr(every, name), many), which[..., None, None], 2)[:, :, 0]
        assert np.abs(getattr(found, name) - of_it).max() < 1e-3  # equal depths are ties


@pytest.mark.parametrize("many", [2, 3])
def test_alpha_is_coverage_and_right_over_any_background(any_renderer: ao.Renderer, many: int) -> None:
    """In linear light over white and over black it is what is drawn there at once; no seam, dark or light, along the edge."""
    cut = drawn(any_renderer, SLANTED, many, aovs="image").image
    alpha, colors = cut[..., 3:] / 255.0, decode(cut[..., :3] / 255)
    levels = np.unique(cut[..., 3]).astype(int)
    assert set(np.round(levels * many * many / 255)) == set(range(many * many + 1)), "all shares of a pixel occur"
    for background, light in (("white", 1.0), ("black", 0.0)):
        at_once = drawn(any_renderer, SLANTED, many, aovs="image", background=background).image / 255.0
        over = colors * alpha + light * (1 - alpha)
        assert at_once.shape[2] == 3 and np.abs(over - decode(at_once)).max() <= 1.5 / 255
    inside = cut[(cut[..., 3] == 255)][:, :3].astype(int)
    edge = cut[(cut[..., 3] > 0) & (cut[..., 3] < 255)][:, :3].astype(int)
    assert edge.min() >= inside.min() - 2, "edges keep the colour of what covers them, though nothing else does"


def test_one_sample_costs_nothing() -> None:
    """No pass, no texture, no word: the plan is that of settings which know nothing of samples."""
    settings = ao.Settings(method=PLAIN)
    plan = plan_render(settings, SIZE, ("image", "visibility", "depth", "normal"))
    assert "resolve" not in plan.describe() and not any("resolve" in name for name in plan.culled)
    assert plan.frame == SIZE and "supersample" not in settings.table()


def test_occlusion_is_drawn_once_a_pixel() -> None:
    plan = plan_render(ao.Settings(method=dataclasses.replace(PLAIN, scale=1), supersample=2), SIZE)
    sizes = {step.task.name: step.size for step in plan.steps}
    assert sizes["gbuffer"] == (96, 72) and sizes["bitmask"] == SIZE == sizes["resolve image"]
    assert [step.task.name for step in plan.steps if "resolve" in step.task.name] == ["resolve image"]


def test_tiles_are_the_picture(any_renderer: ao.Renderer) -> None:
    size = (192, 128)
    settings = ao.Settings(method=PLAIN, supersample=2)
    whole = any_renderer.render(STEPPED, camera(), size, settings, aovs="image")
    cut = layout(STEPPED, camera(), size, settings, ("image",), tile=64)
    assert cut is not None and cut.columns * cut.rows == 6
    for tile in cut.tiles():
        part = any_renderer.render(STEPPED, tile.camera(camera(), size), tile.outer.size, unguarded(settings), aovs="image")
        x, y, w, h = tile.inner.x, size[1] - tile.inner.y - tile.inner.h, tile.inner.w, tile.inner.h
        assert np.abs(tile.crop(part.image).astype(int) - whole.image[y : y + h, x : x + w]).max() <= 1


def test_arrays_have_one_sample(any_renderer: ao.Renderer) -> None:
    with pytest.raises(ao.SettingsError, match="one sample a pixel"):
        any_renderer.apply(np.ones((4, 4), np.float32), camera(), settings=ao.Settings(method=PLAIN, supersample=2))
    with pytest.raises(ao.SettingsError, match="1 to 3"):
        ao.Settings(supersample=4)


@pytest.mark.gl
def test_the_command_refuses_more_than_three(capsys: pytest.CaptureFixture[str]) -> None:
    assert "1 to 3" in refused(capsys, "render", "--supersample", 4, "--size", "16x16")
