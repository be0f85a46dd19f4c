"""The WebGL2 runtime in a real browser: Python's pictures, the caller's state, lost contexts, bad input."""

from __future__ import annotations

import base64
import dataclasses
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.export.pipeline import PipelineInputs, pipeline
from ssao_gl.scene.srgb import decode

from .cases import CAMERAS, Case, references, settings

MEDIUM = settings("bitmask", "medium")
ALL = tuple(CAMERAS)


def given(case: Case) -> PipelineInputs:
    return PipelineInputs(case.depth_kind, case.normals, case.color)


def decoded(text: str, size: tuple[int, int]) -> np.ndarray:
    """(h, w, 4) int, row 0 on top."""
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(size[1], size[0], 4)[::-1].astype(int)


COMPARED = {
    "lecture": (settings("lecture"), ALL[:2], ALL[:2]),
    "alchemy": (settings("alchemy"), ALL, ALL),
    "gtao": (settings("gtao"), ALL, ALL),
    "hbao": (settings("hbao"), ALL, ALL),
    "bitmask draft": (settings("bitmask", "draft"), ALL[:1], ALL[3:]),
    "bitmask low": (settings("bitmask", "low"), ALL[3:], ALL[1:2]),
    "bitmask medium": (MEDIUM, ALL, ALL[1:2]),
    **{name: (settings(name), ALL[:1], ALL[3:]) for name in ("crytek", "sao", "starcraft2", "volumetric")},
    "bitmask high": (settings("bitmask", "high"), ALL[1:3], ALL[3:]),
}
"""Name -> settings, cameras without and with normals. Presets take turns: they differ in numbers, and each compiles for seconds."""


@pytest.mark.parametrize("normals", [False, True], ids=["depth alone", "with normals"])
@pytest.mark.parametrize("name", COMPARED)
def test_the_browser_draws_what_python_draws(page: Any, reference: ProcessPoolExecutor, name: str, normals: bool) -> None:
    chosen, *cameras = COMPARED[name]
    cases = [Case(camera, depth_kind="eye" if normals else "window", normals=normals) for camera in cameras[normals]]
    expected = reference.submit(references, chosen, cases)
    page.evaluate("pipeline => { window.ao = new SsaoGl(gl, pipeline); }", pipeline(chosen, given(cases[0])))
    found = [decoded(page.evaluate("job => draw(gl, ao, job)", case.job()), case.size) for case in cases]
    page.evaluate("ao.dispose()")
    renderer, pictures = expected.result()
    assert "SwiftShader" in renderer
    for case, mine, theirs in zip(cases, found, pictures, strict=True):
        off = np.abs(mine[..., 0] - theirs[..., 0].astype(int))
        assert mine[..., 0].std() > 5, case
        assert (off <= 2).mean() >= 0.995, (case, off.max(), (off > 2).mean())


def test_colour_is_dimmed_as_python_dims_it_and_settings_change_live(page: Any, reference: ProcessPoolExecutor) -> None:
    """Radius, strength, power, tint and tolerance of the runtime are those of Python's settings."""
    case = Case("perspective", (63, 41), color=True)
    chosen = settings("alchemy")
    other = dataclasses.replace(
        chosen,
        method=dataclasses.replace(chosen.method, radius=0.4, power=1.7),
        blur=ao.Joint(tolerance=0.6),
        shading=ao.Shading(ambient=0.9, tint="#804020"),
    )
    expected = [reference.submit(references, one, [case]) for one in (chosen, other)]
    page.evaluate("pipeline => { window.ao = new SsaoGl(gl, pipeline); }", pipeline(chosen, given(case)))
    live = {
        "radius": 0.4,
        "power": 1.7,
        "tolerance": 0.6,
        "strength": 0.9,
        "tint": [float(v) for v in decode(np.array([0x80, 0x40, 0x20]) / 255)],
    }
    for change, pictures in zip([{}, live], expected, strict=True):
        page.evaluate("change => ao.set(change)", change)
        found = decoded(page.evaluate("job => draw(gl, ao, job)", case.job()), case.size)
        assert np.abs(found - pictures.result()[1][0].astype(int)).max() <= 2
    assert page.evaluate("ao.settings")["radius"] == 0.4
    page.evaluate("ao.dispose()")
    assert np.abs(expected[0].result()[1][0].astype(int) - expected[1].result()[1][0]).max() > 10


def test_passes_that_a_size_does_not_need_are_left_out(page: Any, reference: ProcessPoolExecutor) -> None:
    """One export of a method whose number of passes follows the size draws sizes below and above its thresholds."""
    chosen, sizes = settings("vom"), [(63, 41), (3, 17), (130, 9)]
    made = pipeline(chosen, PipelineInputs())
    assert any("when" in step for step in made["steps"])
    cases = [Case("perspective", size) for size in sizes]
    expected = [reference.submit(references, chosen, [case]) for case in cases]
    page.evaluate("pipeline => { window.ao = new SsaoGl(gl, pipeline); }", made)
    for case, pictures in zip(cases, expected, strict=True):
        found = decoded(page.evaluate("job => draw(gl, ao, job)", case.job()), case.size)
        assert np.abs(found[..., 0] - pictures.result()[1][0][..., 0].astype(int)).max() <= 2
    page.evaluate("ao.dispose()")


CHEAP = settings("alchemy")


@pytest.fixture(scope="module")
def cheap() -> dict[str, Any]:
    """A pipeline that compiles fast, and has a depth buffer, a table and a filter."""
    return pipeline(CHEAP, PipelineInputs(color=True))


def test_the_callers_state_is_as_it_was(page: Any, cheap: dict[str, Any]) -> None:
    """Every getter of WebGL2 gives after a call what it gave before, whatever state the caller is in."""
    different, asked = page.evaluate("args => stateAfter(...args)", [cheap, Case("perspective", (40, 30), color=True).job()])
    assert asked > 120
    assert different == []


def test_a_thousand_frames_with_resizes_leak_nothing(page: Any, cheap: dict[str, Any]) -> None:
    """Objects made and not deleted are as many after a thousand frames as after two, and none after dispose."""
    early, late, left = page.evaluate("args => leaks(...args)", [cheap, Case("perspective", (16, 12), color=True).job(), 1000])
    assert early == late
    assert early["Texture"] > 3 and early["Program"] > 3
    assert set(left.values()) == {0}


def test_targets_that_cannot_be_drawn_into_are_named_each_time(page: Any, cheap: dict[str, Any]) -> None:
    said, alive = page.evaluate("args => refused(...args)", [cheap, Case("perspective", (16, 12), color=True).job()])
    assert said == ["SsaoGl: pass 'linearize': this browser cannot draw into r32f"] * 2
    assert set(alive.values()) == {0}


def test_a_lost_context_comes_back(page: Any, cheap: dict[str, Any]) -> None:
    """While it is lost, calls return null; afterwards they draw the same picture."""
    before, during, after = page.evaluate("args => lose(...args)", [cheap, Case("perspective", (40, 30), color=True).job()])
    assert during is None
    assert before == after


def test_the_result_can_go_to_the_canvas(page: Any, cheap: dict[str, Any]) -> None:
    same = page.evaluate("args => toTarget(...args)", [cheap, Case("perspective", (40, 30), color=True).job()])
    assert same == [True, True]


MISTAKES = {
    "new SsaoGl(document.createElement('canvas').getContext('webgl'), made)": "WebGL2 context",
    "new SsaoGl(null, made)": "WebGL2 context",
    "new SsaoGl(gl, {})": "expected 'ssao_gl pipeline 1', got 'undefined'",
    "new SsaoGl(without(context(), 'EXT_color_buffer_float'), made)": "EXT_color_buffer_float",
    "ao.apply({})": "resize",
    "ao.resize(0, 10)": "whole pixels",
    "ao.resize(10.5, 10)": "whole pixels",
    "ao.resize(1e6, 10)": "1 to ",
    "sized.apply({ color: depth, projection })": "depth: expected a texture",
    "sized.apply({ depth, projection })": "color: expected a texture",
    "sized.apply({ depth, color: depth, normals: depth, projection })": "normals: export a pipeline",
    "sized.apply({ depth, color: depth })": "16 finite numbers",
    "sized.apply({ depth, color: depth, projection: projection.map(() => NaN) })": "16 finite numbers",
    "sized.apply({ depth, color: depth, projection: projection.map(() => 0) })": "flattens",
    "sized.apply({ depth, color: depth, projection: projection.map((v, i) => (i === 11 ? 1 : v)) })": "looks along +z",
    "sized.apply({ depth, color: depth, projection, clip: 'gl' })": "clip: expected",
    "ao.set({ radios: 1 })": "'radios' cannot change; radius,",
    "ao.set({ radius: -1 })": "out of range",
    "ao.set({ radius: NaN })": "out of range",
    "ao.set({ strength: [1, 2] })": "out of range",
    "gone.apply({ depth, color: depth, projection })": "disposed",
}


@pytest.mark.parametrize("code", MISTAKES)
def test_mistakes_are_refused_in_one_line(page: Any, cheap: dict[str, Any], code: str) -> None:
    said = page.evaluate("args => mistake(...args)", [cheap, code])
    assert said.startswith("SsaoGl: ") and "\n" not in said
    assert MISTAKES[code] in said
