"""Halos by unsharp masking of depth: only behind outlines, only where they are asked for."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..shapes import camera, plane, quad

SIZE = (320, 240)
PAPER = Scene([quad((0, 0, -4), (1, 0, 0), (0, 0.75, 0))])
"""A sheet that leaves background on all sides."""


def image(renderer: ao.Renderer, scene: Scene, cam: Camera = camera(), method: str = "bitmask", **shading: Any) -> np.ndarray:  # noqa: B008
    settings = ao.Settings(method=dataclasses.replace(ao.method(method), radius=0.3), shading=ao.Shading(**shading))
    return renderer.render(scene, cam, SIZE, settings, aovs=("image",), checked=True).image.astype(int)


@pytest.mark.parametrize("tilt", [0.0, 0.9, -1.3])
def test_a_plane_has_no_halo(any_renderer: ao.Renderer, tilt: float) -> None:
    """To the last bit, up to the border; a tilted one that ends before background has none on itself."""
    with_halo, without = (image(any_renderer, plane(tilt), halo=halo, background="black") for halo in (1.0, 0.0))
    assert (with_halo == without).all()


@pytest.mark.parametrize("method", ["bitmask", "vom", "lecture"])
def test_background_is_painted_along_outlines(any_renderer: ao.Renderer, method: str) -> None:
    """In full at the outline, by nothing from the halo's width on; what casts it stays as it is."""
    looks = {"method": method, "background": "white", "halo_width": 0.05}
    painted, plain = (image(any_renderer, PAPER, halo=halo, halo_color="#ff0000", **looks) for halo in (0.5, 0.0))
    off = np.abs(painted - plain)
    row, plain_row = off[SIZE[1] // 2], plain[SIZE[1] // 2]
    sheet = np.flatnonzero((plain_row != 255).any(1))
    first, width = sheet[0], 0.05 * SIZE[1]
    assert (row[first : sheet[-1] + 1] == 0).all()
    assert painted[SIZE[1] // 2, first - 1].tolist() == pytest.approx([255, 127, 127], abs=12)
    assert (row[: first - int(width) - 5] == 0).all() and row[first - int(width) // 2, 1] > 0
    assert (np.diff(row[first - int(width) : first, 1]) >= 0).all()


def test_a_step_has_a_halo_behind_it(any_renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, -9), (20, 0, 0), (0, 20, 0)), *PAPER.meshes])
    painted, plain = (image(any_renderer, scene, halo=halo, method="vom") for halo in (1.0, 0.0))
    off = np.abs(painted - plain).max(-1)[SIZE[1] // 2]
    left = int(np.flatnonzero(off)[-1])
    assert off.max() > 60 and (off[SIZE[0] // 2 - 20 : SIZE[0] // 2 + 20] == 0).all() and left > SIZE[0] // 2


def test_transparent_background_takes_the_halo_as_alpha(any_renderer: ao.Renderer) -> None:
    painted = image(any_renderer, PAPER, halo=1.0, halo_color="#00ff00", background="transparent", halo_width=0.05)
    row = painted[SIZE[1] // 2]
    first = int(np.flatnonzero(row[:, 3] == 255)[0])
    halo = row[:first][(row[:first, 3] > 0)]
    assert len(halo) >= 8 and (halo[:, :3] == [0, 255, 0]).all() and row[0].tolist() == [0, 0, 0, 0]


def test_halos_leave_no_pass_where_nobody_asks() -> None:
    method = ao.Bitmask(radius=0.3)
    plain, haloed = (plan_render(ao.Settings(method=method, shading=ao.Shading(halo=h)), SIZE) for h in (0.0, 0.5))
    assert not any("halo" in step.task.name for step in plain.steps)
    assert [step.task.name for step in haloed.steps if "halo" in step.task.name] == ["halo means", "halo"]
    seen = plan_render(ao.Settings(method=method, shading=ao.Shading(halo=0.5)), SIZE, ["visibility"])
    assert not any(step.task.name.startswith(("halo", "sum")) for step in seen.steps)


def test_colour_larger_than_depth_is_refused(any_renderer: ao.Renderer) -> None:
    depth, color = np.full((24, 32), 5.0, np.float32), np.zeros((48, 64, 3), np.uint8)
    settings = ao.Settings(method=ao.Bitmask(radius=0.3), shading=ao.Shading(halo=0.5))
    with pytest.raises(ao.SettingsError, match=r"shading\.halo: colour is larger than depth"):
        any_renderer.apply(depth, camera(), color=color, settings=settings)


@pytest.mark.parametrize(("name", "value"), [("halo", 1.5), ("halo", -0.1), ("halo_color", "blak"), ("halo_width", 0)])
def test_what_is_no_halo_is_said(name: str, value: Any) -> None:
    with pytest.raises(ao.SettingsError, match=rf"shading\.{name}"):
        ao.Shading(**{name: value})
