"""What is left out changes nothing: rules on and off give the same picture, and do less work."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import BLOCK_OPEN
from ssao_gl.pipeline.settings import CULLING_RULES
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.screen_bounds import screen_bounds

from ..shapes import camera, corner, plane, quad

SIZE = (320, 180)
KEEP_ALL = tuple(CULLING_RULES)


def presets() -> list[str]:
    return list(ao.Bitmask.presets)


def settings(preset: str, keep: Sequence[str] = (), radius: float = 0.7) -> ao.Settings:
    return ao.Settings(method=ao.Bitmask(**{**ao.Bitmask.presets[preset], "radius": radius}), keep=tuple(keep))


def room() -> tuple[Scene, Camera]:
    """The inside of a box with a smaller box on its floor."""
    walls = [
        quad((0, -2, 0), (4, 0, 0), (0, 0, 4)),
        quad((0, 2, 0), (4, 0, 0), (0, 0, 4)),
        quad((0, 0, -4), (4, 0, 0), (0, 2, 0)),
    ]
    walls += [
        quad((4, 0, 0), (0, 0, 4), (0, 2, 0)),
        quad((-4, 0, 0), (0, 0, 4), (0, 2, 0)),
        quad((0, 0, 4), (4, 0, 0), (0, 2, 0)),
    ]
    box = [quad((0.5, -1.4, -1.5), (0.6, 0, 0), (0, 0, 0.6)), quad((0.5, -1.7, -0.9), (0.6, 0, 0), (0, 0.3, 0))]
    return Scene([*walls, *box]), Camera.perspective(1.2, 0.1, 40, look_at((-1, 0.5, 3.5), (0.3, -1, -2)))


@pytest.mark.parametrize("preset", presets())
def test_rules_change_nothing(renderer: ao.Renderer, preset: str, embedded: Scene) -> None:
    """Not even by one step, in an exterior before background, in a room of flat faces, and on a bare plane."""
    outside, inside = embedded.cameras[0], room()
    views = [(embedded, outside), inside, (plane(0.9), camera()), (corner(), camera())]
    for scene, cam in views:
        on, off = (
            renderer.render(scene, cam, SIZE, settings(preset, keep), aovs=("visibility", "image")) for keep in ((), KEEP_ALL)
        )
        np.testing.assert_array_equal(on.visibility, off.visibility)
        np.testing.assert_array_equal(on.image, off.image)


def test_open_blocks_are_found_where_they_pay(any_renderer: ao.Renderer) -> None:
    """In the room of flat faces; and those that are found are open."""
    scene, cam = room()
    chosen = settings("ultra", radius=0.3)
    with any_renderer.ctx.current():
        made, frame, seen = any_renderer._ready(scene, cam, (640, 360), chosen, ("visibility",))
        found = frame.run(made.view, scene=seen, region=made.region).read(BLOCK_OPEN)[..., 0] > 0
    assert found.mean() > 0.4
    off = any_renderer.render(scene, cam, (640, 360), settings("ultra", KEEP_ALL, 0.3), aovs=("visibility",)).visibility
    border = made.region.image_rect[0] if made.region.image_rect else 0
    blocks = np.kron(found, np.ones((16, 16), bool))[border : border + 360, border : border + 640][::-1]
    assert off[blocks].min() == 1.0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"keep": ("open",)}, "switched off"),
        ({"normals": "shading"}, "normals are not those"),
        ({"method": ao.Bitmask(radius=1.0)}, "taps a pixel and side cost less"),
        ({"method": ao.Alchemy(radius=1.0)}, "alchemy may darken"),
    ],
)
def test_the_reason_is_told(any_renderer: ao.Renderer, change: dict[str, object], reason: str) -> None:
    scene, cam = room()
    chosen = dataclasses.replace(settings("high"), **change)
    picture = any_renderer.render(scene, cam, SIZE, chosen, aovs=("visibility",))
    assert any("open blocks" in line and reason in line for line in picture.report["plan"])


def test_adaptive_spends_taps_where_probes_see_something(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """Its error is bounded: it may miss what lies between probes, which is little."""
    plain = settings("medium")
    adaptive = dataclasses.replace(plain, method=dataclasses.replace(plain.method, adaptive=True))
    one, two = (any_renderer.render(embedded, None, SIZE, s, aovs=("visibility",)).visibility for s in (plain, adaptive))
    assert np.abs(one - two).mean() < 0.003
    three = any_renderer.render(
        embedded, None, SIZE, dataclasses.replace(adaptive, keep=("adaptive",)), aovs=("visibility",)
    ).visibility
    np.testing.assert_array_equal(one, three)


def test_footprint_holds_what_is_drawn(any_renderer: ao.Renderer, embedded: Scene) -> None:
    far_away = Camera.perspective(0.9, 0.1, 100, look_at((9, 6, 12), (0, 0, 0)))
    view = far_away.view(SIZE)
    rect = screen_bounds(embedded.bounds, far_away, view)
    assert rect is not None and rect[2] * rect[3] < 0.5 * SIZE[0] * SIZE[1]
    x, y, w, h = rect
    covered = any_renderer.render(embedded, far_away, SIZE, aovs=("depth",)).depth[::-1] > 0
    assert covered[y : y + h, x : x + w].sum() == covered.sum() > 0
    assert screen_bounds(embedded.bounds, Camera.perspective(0.9, 0.1, 100), view) is None  # from inside the box


def test_the_default_stays_within_its_memory() -> None:
    """Beyond the caller's own depth, normals and picture, at 1280x720."""
    from ssao_gl.pipeline.build import plan_apply

    assert plan_apply(ao.Settings(method=ao.Bitmask(radius=1.0)), (1280, 720), depth="eye").bytes <= 12 * 2**20
