"""Nothing is left behind: OpenGL objects and memory after a thousand frames, and after a thousand failures."""

from __future__ import annotations

import gc
import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import ShaderError, SsaoError

from .. import shapes
from ..guest_program import alive
from ..volumes import ball, slab

SIZE = (16, 12)
CAMERA = ao.Camera.perspective(0.9, 0.1, 40.0)
SETTINGS = [ao.Settings(method=ao.registry()[name](radius=0.5)) for name in ("alchemy", "bitmask")]
DEPTH = np.full((12, 16), 4, np.float32)
COLOR = np.full((12, 16, 3), 200, np.uint8)
NAMES = 1 << 17
"""Some drivers never give a name of a framebuffer again."""

Frame = Callable[[int], Any]


def rendered(renderer: ao.Renderer) -> Frame:
    """Scenes, sizes and settings that change."""
    scenes = [shapes.corner()]

    def frame(number: int) -> Any:
        if number % 10 == 0:
            scenes[0] = shapes.corner()
        return renderer.render(scenes[0], CAMERA, (16 + number // 5 % 2, 12), SETTINGS[number // 10 % 2]).image

    return frame


def rays_through_voxels(renderer: ao.Renderer) -> Frame:
    """Volumes that change: 3-D textures, and tables of transfer functions."""
    scenes = [ao.as_scene(ball(1.0, 12)), ao.as_scene(slab(0.9, n=12))]
    cameras = [scene.default_camera(SIZE) for scene in scenes]

    def frame(number: int) -> Any:
        which = number // 10 % 2
        if number % 10 == 0:
            scenes[0] = ao.as_scene(ball(1.0, 12))
        return renderer.render(scenes[which], cameras[which], SIZE, SETTINGS[0]).image

    return frame


def applied(renderer: ao.Renderer) -> Frame:
    return lambda number: renderer.apply(DEPTH, CAMERA, color=COLOR, settings=SETTINGS[number // 10 % 2]).image


def embedded(renderer: ao.Renderer) -> Frame:
    """In a program of the caller's."""
    depth = renderer.ctx.mgl.texture(SIZE, 1, DEPTH.tobytes(), dtype="f4")
    effect = ao.Effect(renderer.ctx, SIZE, SETTINGS[0])

    def frame(number: int) -> Any:
        if number % 10 == 0:
            effect.settings = SETTINGS[number // 10 % 2]
            effect.resize(*SIZE)
        effect.apply(depth=depth, camera=CAMERA, depth_kind="eye", timed=True)
        return len(effect.times)

    return frame


WAYS = {"render": rendered, "volumes": rays_through_voxels, "apply": applied, "effect": embedded}


def resident() -> int:
    """Bytes of this process in memory."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.parametrize("way", WAYS)
def test_a_thousand_frames(way: str, any_renderer: ao.Renderer) -> None:
    with any_renderer.ctx.current():
        frame = WAYS[way](any_renderer)
        for number in range(200):
            frame(number)
        objects, memory = alive(any_renderer.ctx, NAMES), resident()
        for number in range(1000):
            frame(number)
        assert resident() <= 1.05 * memory
        assert alive(any_renderer.ctx, NAMES) == objects


class Faulty:
    """A moderngl context that fails to make its ``at``-th object."""

    MAKERS = (
        "texture",
        "texture3d",
        "depth_renderbuffer",
        "framebuffer",
        "buffer",
        "program",
        "vertex_array",
        "sampler",
        "query",
    )

    def __init__(self, mgl: moderngl.Context, at: int, error: Callable[[], BaseException]) -> None:
        self._mgl, self.left, self._error = mgl, at, error

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._mgl, name)
        if name not in self.MAKERS:
            return found

        def make(*given: Any, **named: Any) -> Any:
            self.left -= 1
            if self.left == 0:
                raise self._error()
            return found(*given, **named)

        return make


@contextmanager
def fault(ctx: ao.gl.Context, at: int, error: Callable[[], BaseException]) -> Iterator[Faulty]:
    whole = ctx.mgl
    made = Faulty(whole, at, error)
    ctx.mgl = made  # type: ignore[assignment]
    try:
        yield made
    finally:
        ctx.mgl = whole


ERRORS: list[tuple[Callable[[], BaseException], type[BaseException]]] = [
    (lambda: moderngl.Error("out of memory"), SsaoError),
    (MemoryError, MemoryError),
    (KeyboardInterrupt, KeyboardInterrupt),
]


@pytest.mark.parametrize("way", WAYS)
def test_a_thousand_failures_to_make_something(way: str, any_renderer: ao.Renderer) -> None:
    """Whatever cannot be made in a frame: an error, nothing left behind, and the next frame is as if nothing had been."""
    ctx = any_renderer.ctx
    with ctx.current():
        frame = WAYS[way](any_renderer)
        before = [frame(number) for number in range(200)][-20:]
        with fault(ctx, -1, MemoryError) as counter:
            frame(0), frame(10)
        made = -1 - counter.left
        assert made >= (1 if way == "volumes" else 11), "a frame after a change makes textures or targets anew"
        objects, memory, failures = alive(ctx, NAMES), resident(), 0
        for turn in itertools.count():
            at, (error, seen) = turn // len(ERRORS) % made + 1, ERRORS[turn % len(ERRORS)]
            with fault(ctx, at, error) as faulty:
                try:
                    frame(10 * (turn // made))
                    assert faulty.left > 0, "swallowed"
                except seen as found:
                    failures += 1
                    assert not isinstance(found, SsaoError) or "\n" not in str(found)
            if failures == 1000:
                break
        np.testing.assert_equal([frame(number) for number in range(180, 200)], before)
        assert resident() <= 1.05 * memory
        assert alive(ctx, NAMES) == objects


def wrong(renderer: ao.Renderer, effect: ao.Effect, depth: moderngl.Texture) -> list[Callable[[], Any]]:
    """Calls with what callers get wrong."""
    small = renderer.ctx.mgl.texture((2, 2), 1, dtype="f4")
    lost = ao.Camera.from_matrix(np.diag([1.0, 1.0, 1.0, 0.0]) + np.eye(4, k=-1))
    return [
        lambda: renderer.apply(DEPTH[0], CAMERA),
        lambda: renderer.apply(DEPTH, CAMERA, color=COLOR[1:]),
        lambda: renderer.apply(DEPTH, CAMERA, normals=COLOR),
        lambda: renderer.apply(DEPTH, CAMERA, depth_kind="eyes"),
        lambda: renderer.apply(DEPTH, lost),
        lambda: renderer.render(shapes.corner(), CAMERA, (0, 12)),
        lambda: renderer.render(shapes.corner(), CAMERA, (1 << 16, 12)),
        lambda: renderer.render(shapes.corner(), lost, SIZE),
        lambda: renderer.render(shapes.corner(), CAMERA, SIZE, aovs=("visiblity",)),
        lambda: effect.apply(depth=small, camera=CAMERA),
        lambda: effect.apply(depth=10**6, camera=CAMERA),
        lambda: effect.apply(depth=depth, camera=CAMERA, depth_kind="eyes"),
        lambda: effect.apply(depth=depth, camera=CAMERA, target=10**6),
        lambda: effect.apply(depth=depth, camera=lost),
    ]


def test_a_thousand_wrong_calls(any_renderer: ao.Renderer) -> None:
    ctx = any_renderer.ctx
    with ctx.current():
        depth = ctx.mgl.texture(SIZE, 1, DEPTH.tobytes(), dtype="f4")
        effect = ao.Effect(ctx, SIZE, SETTINGS[0])
        calls = wrong(any_renderer, effect, depth)
        objects, memory = {}, 0
        for number in range(1000 + len(calls)):
            if number == len(calls):
                objects, memory = alive(ctx, NAMES), resident()
            with pytest.raises(SsaoError) as found:
                calls[number % len(calls)]()
            assert "\n" not in str(found.value)
        assert resident() <= 1.05 * memory
        assert alive(ctx, NAMES) == objects


def test_shaders_that_do_not_compile(renderer: ao.Renderer) -> None:
    """Neither do they stay, nor does the program that was tried."""
    ctx = renderer.ctx
    with ctx.current():
        kit = renderer._resources
        objects = alive(ctx, NAMES)
        for number in range(100):
            with pytest.raises(ShaderError, match=r"composite\.frag"):
                kit.program("fullscreen.vert", "composite.frag", {f"vec4 broken{number}": "="})
        assert alive(ctx, NAMES) == objects
