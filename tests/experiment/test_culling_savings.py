"""What the rules save is measured against what they leave: shares by masks, pictures that stay as they are."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.experiment.culling_savings import ALL_RULES, benchmark_rules, shaded
from ssao_gl.pipeline.settings import CULLING_RULES
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.scene.pose import look_at

from ..command_line import run
from ..passes.test_culling import room, settings

SIZE = (320, 180)
AFAR = Camera.perspective(0.9, 0.1, 100, look_at((9, 6, 12), (0, 0, 0)))


def test_background_before_an_object(any_renderer: ao.Renderer, embedded: Scene) -> None:
    found = benchmark_rules(any_renderer, embedded, AFAR, SIZE, settings("medium"), rounds=1)
    assert [one.rule for one in found] == ["background", ALL_RULES]
    covered = (any_renderer.render(embedded, AFAR, SIZE, aovs=("depth",)).depth > 0).mean()
    for one in found:
        assert one.pixels == pytest.approx(covered) and covered <= one.taps < covered + 0.05
        assert one.difference == one.bound == 0 and one.on > 0 and one.off > 0 and one.ratio > 0


def test_open_blocks_of_a_room(any_renderer: ao.Renderer) -> None:
    """Blocks lie where the picture is open: their rows and columns are those of the image."""
    scene, cam = room()
    chosen, size = settings("ultra", radius=0.3), (640, 360)
    background, blocks, together = benchmark_rules(any_renderer, scene, cam, size, chosen, rounds=1)
    assert background.pixels == 1.0 and blocks.rule == "open"
    assert blocks.pixels == together.pixels < 0.7 and blocks.difference == blocks.bound == 0
    covered, closed = shaded(any_renderer, scene, cam, size, chosen)
    visibility = any_renderer.render(scene, cam, size, chosen, aovs=("visibility",)).visibility
    assert covered.all() and closed.mean() == blocks.pixels and visibility[~closed].min() == 1.0


def test_of_adaptive_taps_no_bound_is_claimed(any_renderer: ao.Renderer, embedded: Scene) -> None:
    plain = settings("medium")
    adaptive = dataclasses.replace(plain, method=dataclasses.replace(plain.method, adaptive=True))
    found = {one.rule: one for one in benchmark_rules(any_renderer, embedded, AFAR, SIZE, adaptive, rounds=1)}
    assert list(found) == ["background", "adaptive", ALL_RULES]
    assert found["background"].bound == 0 and found["adaptive"].bound is None is found[ALL_RULES].bound
    assert found[ALL_RULES].pixels < found["background"].pixels and "not known" in found[ALL_RULES].cells()


def test_nothing_is_measured_of_what_is_switched_off(any_renderer: ao.Renderer, embedded: Scene) -> None:
    assert benchmark_rules(any_renderer, embedded, AFAR, SIZE, settings("medium", tuple(CULLING_RULES)), rounds=1) == []


@pytest.mark.gl
def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("explain", "--measure", "--rounds", 1, "--size", "160x90")
    _, out, _ = run(*arguments, capsys=capsys)
    assert "Rules on and off: " in out and "background" in out
    _, out, _ = run(*arguments, "--json", capsys=capsys)
    measured = json.loads(out)["measured"]
    assert measured["where"] and [one["rule"] for one in measured["rules"]] == ["background", ALL_RULES]
    assert 0 < measured["rules"][0]["pixels"] < 1
    _, out, _ = run(*arguments, "--keep-all", capsys=capsys)
    assert "no rule is in force" in out


def test_shares_at_sizes_that_blocks_do_not_divide(any_renderer: ao.Renderer) -> None:
    scene, cam = room()
    covered, closed = shaded(any_renderer, scene, cam, (333, 187), settings("ultra", radius=0.3))
    assert covered.shape == closed.shape == (187, 333) and np.any(~closed)
