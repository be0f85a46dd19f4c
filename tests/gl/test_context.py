"""Contexts side by side in one thread: a caller's own stays current, and renderers do not disturb each other."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene

from ..conftest import openable

CAMERA = ao.Camera.perspective(0.9, 0.5, 50.0)
DEPTH = np.full((12, 16), 3.0)


def shade(ctx: moderngl.Context, value: float) -> int:
    """Fills a framebuffer and reads it back: only right while ``ctx`` is current."""
    fbo = ctx.framebuffer([ctx.texture((4, 4), 4)])
    fbo.clear(value, value, value, value)
    (seen,) = set(fbo.read(components=4))
    for made in (*fbo.color_attachments, fbo):
        made.release()
    return int(seen)


def test_a_callers_context_stays_current(provider: str) -> None:
    """One-shot calls and a renderer that lives on, all on a context of the same library as the caller's."""
    with ao.gl.open(provider) as mine:
        if provider == "osmesa":
            return  # it cannot tell enough of a context to go back to it
        assert shade(mine.mgl, 0.2) == 51
        assert (ao.occlusion(DEPTH, CAMERA, provider=provider) > 0.9).all()
        assert shade(mine.mgl, 0.4) == 102
        with ao.Renderer(provider) as renderer:
            assert shade(mine.mgl, 0.6) == 153
            for _ in range(2):
                assert (renderer.apply(DEPTH, CAMERA).visibility > 0.9).all()
                assert shade(mine.mgl, 0.8) == 204
        assert shade(mine.mgl, 1.0) == 255
        assert mine.mgl.error == "GL_NO_ERROR"


def test_a_context_that_was_given_is_not_destroyed(provider: str) -> None:
    with ao.gl.open(provider) as mine:
        for _ in range(2):
            assert (ao.occlusion(DEPTH, CAMERA, provider=mine) > 0.9).all()
        assert not mine.released and shade(mine.mgl, 0.2) == 51


def test_renderers_take_turns(provider: str) -> None:
    scene = default_scene()
    with ao.Renderer(provider) as first, ao.Renderer(provider) as second:
        pictures = [r.render(scene, size=(48, 36)) for r in (first, second, first, second)]
        assert pictures[0].image.std() > 10
        for picture in pictures[1:]:
            np.testing.assert_array_equal(picture.image, pictures[0].image)
        first.release()
        np.testing.assert_array_equal(second.render(scene, size=(48, 36)).image, pictures[0].image)


@pytest.mark.skipif("egl-gl" not in openable(), reason="moderngl's backend egl needs the same library as egl-gl")
def test_beside_a_context_that_moderngl_made() -> None:
    mgl = moderngl.create_context(standalone=True, backend="egl")
    for name in ("egl-es", "egl-gl"):
        if name in openable():
            assert (ao.occlusion(DEPTH, CAMERA, provider=name) > 0.9).all()
            assert shade(mgl, 0.2) == 51
    mgl.release()


def test_any_context_of_an_api() -> None:
    for name in openable():
        with ao.gl.open(name) as ctx:
            other = {"es": "gl", "gl": "es"}[ctx.api]
        with pytest.raises(ao.ContextError, match=f"gives .*, not {other}"):
            ao.gl.open(name, api=other)  # type: ignore[arg-type]


@pytest.mark.gl
def test_renderers_of_all_libraries_take_turns() -> None:
    """OSMesa and EGL share what is current, and neither notices what the other one does to it."""
    settings = [ao.Settings(method=ao.Alchemy(radius=radius)) for radius in (0.5, 1.0)]
    depth = np.linspace(2, 6, 12 * 16, dtype=np.float32).reshape(12, 16)
    depth[3:8, 4:9] -= 0.8

    def drawn(renderer: ao.Renderer) -> np.ndarray:
        return np.stack([renderer.apply(depth, CAMERA, settings=s, checked=True).visibility for s in settings])

    alone = {}
    for name in openable():
        with ao.Renderer(name) as renderer:
            alone[name] = drawn(renderer)
    renderers = [ao.Renderer(name) for name in openable()]
    try:
        for turn in (*renderers, *reversed(renderers)):
            np.testing.assert_array_equal(drawn(turn), alone[turn.ctx.provider])
        renderers.pop(0).release()
        for turn in (*renderers, *reversed(renderers)):
            np.testing.assert_array_equal(drawn(turn), alone[turn.ctx.provider])
    finally:
        for renderer in renderers:
            renderer.release()
