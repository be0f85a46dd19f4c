"""Threads: a renderer works in any of them, one at a time; what cannot says so."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray

import ssao_gl as ao
from ssao_gl.gl.ownership import Ownership

from ..conftest import openable

REBINDS = ("egl-es", "egl-gl", "osmesa", "angle", "swiftshader")
Result = TypeVar("Result")


def in_threads(count: int, work: Callable[[], Result]) -> list[Result | Exception]:
    found: list[Result | Exception] = []

    def run() -> None:
        try:
            found.append(work())
        except Exception as error:
            found.append(error)

    threads = [threading.Thread(target=run) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive(), "waits for ever"
    return found


def draw(renderer: ao.Renderer, scene: ao.Scene) -> NDArray[np.float32]:
    return renderer.render(scene, None, (48, 36)).visibility


def test_eight_threads_share_a_renderer(provider: str, embedded: ao.Scene) -> None:
    with ao.Renderer(provider) as renderer:
        right = draw(renderer, embedded)
        found = in_threads(8, lambda: [draw(renderer, embedded) for _ in range(4)])
        for drawn in found:
            if provider in REBINDS:
                np.testing.assert_array_equal(drawn, [right] * 4)
            else:
                assert isinstance(drawn, ao.ContextError) and "one Renderer a thread" in str(drawn)
        np.testing.assert_array_equal(draw(renderer, embedded), right)


def test_eight_threads_with_a_renderer_each(provider: str, embedded: ao.Scene) -> None:
    """Software renderers draw wrong pictures with two contexts at the same time, and so take turns."""

    def own() -> list[NDArray[np.float32]]:
        with ao.Renderer(provider) as renderer:
            return [draw(renderer, embedded) for _ in range(3)]

    right, *_ = own()
    for drawn in in_threads(8, own):
        np.testing.assert_array_equal(drawn, [right] * 3)


def test_software_renderers_never_draw_at_the_same_time(provider: str, embedded: ao.Scene) -> None:
    """Nor do those of two libraries: while one is held, the others wait."""
    with ao.Renderer(openable()[0]) as held, ao.Renderer(provider) as other:
        if not (held.ctx.software and other.ctx.software):
            pytest.skip("a GPU draws for many at the same time")
        drawn: list[NDArray[np.float32]] = []
        thread = threading.Thread(target=lambda: drawn.append(draw(other, embedded)))
        with held.ctx.current():
            thread.start()
            thread.join(0.5)
            assert not drawn and thread.is_alive()
        thread.join(60)
        assert len(drawn) == 1


def test_a_renderer_outlives_the_thread_that_made_it(provider: str, embedded: ao.Scene) -> None:
    if provider not in REBINDS:
        pytest.skip("stays in its thread")
    with ao.Renderer(provider) as other:
        right = draw(other, embedded)

    def made() -> ao.Renderer:
        renderer = ao.Renderer(provider)
        draw(renderer, embedded)
        return renderer

    for renderer in in_threads(2, made):
        assert isinstance(renderer, ao.Renderer)
        np.testing.assert_array_equal(draw(renderer, embedded), right)
        renderer.release()
        renderer.release()
        assert renderer.ctx.released


def test_one_that_a_thread_releases_is_gone_for_the_others(provider: str, embedded: ao.Scene) -> None:
    if provider not in REBINDS:
        pytest.skip("stays in its thread")
    renderer = ao.Renderer(provider)
    assert in_threads(1, renderer.release) == [None]
    with pytest.raises(ao.ContextError, match="was released"):
        draw(renderer, embedded)


def test_a_context_that_is_current_elsewhere_is_refused(embedded: ao.Scene) -> None:
    name = next((name for name in openable() if name.startswith("egl")), None)
    if name is None:
        pytest.skip("needs EGL, which notices")
    with ao.gl.open(name) as mine:  # and stays current here
        renderer = ao.Renderer(mine)
        (error,) = in_threads(1, lambda: draw(renderer, embedded))
        assert isinstance(error, ao.ContextError) and "one Renderer a thread" in str(error)
        assert draw(renderer, embedded).shape == (36, 48)


def test_an_effect_says_where_no_context_is_current(provider: str) -> None:
    camera = ao.Camera.perspective(0.9, 0.5, 50.0)
    with ao.gl.open(provider) as mine:
        depth = mine.mgl.texture((16, 12), 1, np.full((12, 16), 3, "f4").tobytes(), dtype="f4")
        with ao.Effect(mine, (16, 12), ao.Settings(method=ao.Bitmask(radius=0.3))) as effect:
            works = [
                lambda: effect.apply(depth=depth, camera=camera, depth_kind="eye"),
                lambda: effect.resize(8, 8),
                lambda: setattr(effect, "settings", ao.Settings(method=ao.Bitmask(radius=0.5))),
                effect.release,
            ]
            for work in works:
                (error,) = in_threads(1, work)
                assert isinstance(error, ao.ContextError) and "no OpenGL context is current in this thread" in str(error)
            assert effect.size == (16, 12) and effect.settings.method.radius == 0.3, "what is refused changes nothing"
            effect.apply(depth=depth, camera=camera, depth_kind="eye")


def test_what_cannot_be_rebound_stays_in_its_thread() -> None:
    owned = Ownership()
    with owned.held():
        pass

    def use() -> None:
        with owned.held():
            pass

    (error,) = in_threads(1, use)
    assert isinstance(error, ao.ContextError) and "one Renderer a thread" in str(error)
