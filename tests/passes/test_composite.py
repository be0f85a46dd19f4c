"""The image's light: tint and contrast of what is hidden, and nothing of them where they are off."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.graph.draws import Fullscreen
from ssao_gl.pipeline.build import plan_apply
from ssao_gl.pipeline.light import Light
from ssao_gl.scene.srgb import decode, encode

SIZE = (48, 32)
CAMERA = ao.Camera.perspective(0.9, 0.1, 50.0)


def depth() -> np.ndarray:
    """(h, w): a step in front of a wall, background on the right."""
    z = np.full(SIZE[::-1], 4.0)
    z[:, 16:24] = 3.5
    z[:, 40:] = 0
    return z


def color() -> np.ndarray:
    rgb = np.zeros((*SIZE[::-1], 3), np.uint8)
    rgb[..., 0], rgb[..., 1], rgb[..., 2] = 220, np.linspace(20, 255, SIZE[0]), 128
    return rgb


@pytest.mark.parametrize(
    "shading",
    [ao.Shading(ambient=0.8, tint="#804020", power=2.0), ao.Shading(ambient=1.0, power=0.5), ao.Shading(tint="white")],
)
def test_hidden_light_is_tinted_and_visibility_raised(renderer: ao.Renderer, shading: ao.Shading) -> None:
    chosen = ao.Settings(method=ao.Alchemy(radius=1.0), shading=shading)
    drawn = renderer.apply(depth(), CAMERA, color=color(), settings=chosen)
    tint = np.array(shading.tint_linear)
    visibility = drawn.arrays["visibility"][..., None].astype(float) ** shading.power
    light = 1 - shading.ambient * (1 - tint) * (1 - visibility)
    expected = 255 * encode(decode(color() / 255.0) * light)
    assert np.abs(drawn.arrays["image"][..., :3] - expected).max() <= 2
    assert drawn.arrays["visibility"].min() < 0.8


@pytest.mark.parametrize("light", [None, Light(), Light(indirect="tint")], ids=["ambient", "lit", "bounces"])
def test_rendered_scenes_have_them_too(renderer: ao.Renderer, embedded: ao.Scene, light: Light | None) -> None:
    method = ao.Alchemy(radius=0.5)
    plain, warm, white, dark = (
        renderer.render(
            embedded, None, SIZE, settings=ao.Settings(method=method, shading=shading, light=light), aovs=("image",)
        ).arrays["image"]
        for shading in (ao.Shading(), ao.Shading(tint="#ff0000"), ao.Shading(tint="white"), ao.Shading(power=2.0))
    )
    more = warm.astype(int) - plain
    assert more[..., 0].max() > 10 and np.abs(more[..., 1:3]).max() <= 2
    assert (white.astype(int) - plain).min() >= -2
    less = plain.astype(int) - dark
    assert less.min() >= -2 and less.max() > 10


def test_off_they_cost_nothing() -> None:
    def composite(shading: ao.Shading) -> Fullscreen:
        plan = plan_apply(ao.Settings(method=ao.Alchemy(radius=1.0), shading=shading), SIZE, outputs=("image",))
        draw = plan.steps[-1].task.draw
        assert isinstance(draw, Fullscreen)
        return draw

    assert set(composite(ao.Shading()).uniforms) == {"u_ambient"} and "TONED" not in composite(ao.Shading()).defines
    assert "TONED" in composite(ao.Shading(power=2.0)).defines


def test_what_cannot_be_drawn_is_refused(any_renderer: ao.Renderer) -> None:
    with pytest.raises(SettingsError, match=r"shading.tint='red': must look like #rrggbb"):
        ao.Shading(tint="red")
    with pytest.raises(SettingsError, match=r"shading.power=0"):
        ao.Shading(power=0)
    larger = np.repeat(np.repeat(color(), 2, 0), 2, 1)
    chosen = ao.Settings(method=ao.Alchemy(radius=1.0), shading=ao.Shading(power=2.0))
    with pytest.raises(SettingsError, match=r"shading.power: colour is larger"):
        any_renderer.apply(depth(), CAMERA, color=larger, settings=chosen)
