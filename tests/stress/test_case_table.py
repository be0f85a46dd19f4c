"""The stress battery without OpenGL: its table, its random cases, its verdicts, how it makes failures smaller."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.cli import main
from ssao_gl.methods.base import Deviation
from ssao_gl.stress import case_table, fuzz, report
from ssao_gl.stress.analytic_depth import as_half_floats, ball_depth, cast, flat, room, window_depth
from ssao_gl.stress.case import Case
from ssao_gl.stress.catalogue import cases
from ssao_gl.stress.outcomes import NotApplicable
from ssao_gl.stress.reduce import crop, smaller
from ssao_gl.stress.runner import Broken
from ssao_gl.stress.shapes import lens
from ssao_gl.stress.shot import Shot, apart, share
from ssao_gl.stress.specimen import specimens
from ssao_gl.stress.verdicts import ABSENT, DECLARED, FAIL, PASS, CaseResult, judged, runs

PAGE = Path(case_table.__file__).with_name("CASES.md")


def test_the_page_of_cases_is_up_to_date() -> None:
    """Write it with: ssao-gl stress --list --markdown > ssao_gl/stress/CASES.md"""
    assert PAGE.read_text("utf-8") == case_table.case_table_markdown()


def test_every_trap_has_a_case() -> None:
    assert len(case_table.TRAPS) == 45
    assert {trap for case in cases().values() for trap in case.traps} == set(range(1, 46))


@pytest.mark.parametrize("case", cases().values(), ids=lambda case: case.name)
def test_a_case_says_what_it_promises(case: Case) -> None:
    assert len(case.promise) > 20 and case.unit and case.bound >= 0
    assert case.why or abs(case.bound - 1 / 255) < 1e-5, "a bound that is not one step of 8 bits has a reason"


def test_contracts_that_methods_declare_are_asked_for() -> None:
    """A declared exception that no case looks at would be an excuse for nothing."""
    asked = {case.contract for case in cases().values()} | {kind for case in cases().values() for kind in case.asks}
    assert {contract for kind in ao.registry().values() for contract in kind.exceptions} <= asked  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["alchemy", "bitmask", "reference"])
def test_recommended_methods_break_nothing(name: str) -> None:
    assert dict(ao.registry()[name].exceptions) == {}  # type: ignore[attr-defined]


def test_depth_by_rays_is_exact() -> None:
    camera, size = lens(), (32, 24)
    z = cast(camera, size, flat((0, 0, -5), (0, 0.5, 1)))
    points = camera.view(size).points(z)
    np.testing.assert_allclose(points @ [0, 0.5, 1], -5, rtol=1e-12)
    points = camera.view(size).points(cast(camera, size, ball_depth((0, 0, -5), 1.0)))
    seen = points[..., 2] < 0
    assert seen.sum() > 20 and not seen.all()
    np.testing.assert_allclose(np.linalg.norm(points[seen] - [0, 0, -5], axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("camera", [lens(), lens(None), ao.Camera.orthographic(6.0, 0.0, 40.0)])
def test_window_depth_and_back(camera: ao.Camera) -> None:
    z = cast(camera, (16, 12), *room())
    d = window_depth(camera, z, np.float64)
    c = camera.view((16, 12)).depth_constants
    y, x = np.mgrid[:12, :16]
    p = np.stack([(x + 0.5) / 16, 1 - (y + 0.5) / 12, d - c["u_depth_far"], np.ones_like(d)], -1)
    with np.errstate(all="ignore"):
        back = (p @ c["u_depth_num"]) / (p @ c["u_depth_den"])
    np.testing.assert_allclose(np.where(z > 0, back, 0), z, rtol=1e-9)
    assert ((d >= 0) & (d <= 1)).all() and (np.abs(as_half_floats(d, 16) - d) <= 0.5 / 65535 + 1e-12).all()


def test_differences() -> None:
    a, b = np.array([0.0, 0.5, 1.0, 1.0]), np.array([0.0, 0.5 + 1 / 255, 1.0, 0.9])
    assert share(a, b) == 0.25 and apart(a, b) == pytest.approx((1 / 255 + 0.1) / 4)


@pytest.mark.parametrize("number", [0, 5, 17, 33, 70, 1234567])
def test_a_random_case_is_its_seed_and_number(number: int) -> None:
    every = [fuzz.random_shot(3, number, subject) for subject in specimens()]
    again = fuzz.random_shot(3, number, specimens()[0])
    for shot in (*every, again):
        np.testing.assert_array_equal(shot.depth, every[0].depth)
        np.testing.assert_array_equal(shot.camera.view((8, 6)).projection, every[0].camera.view((8, 6)).projection)
        assert (shot.kind, shot.blur, shot.radius) == (every[0].kind, every[0].blur, every[0].radius)
    other = fuzz.random_shot(4, number, specimens()[0])
    assert other.depth is None or other.depth.shape != every[0].depth.shape or not np.array_equal(other.depth, every[0].depth)  # type: ignore[union-attr]


def test_random_cases_are_of_all_kinds() -> None:
    subject = specimens()[0]
    shots = [fuzz.random_shot(0, number, subject) for number in range(0, 2000)]
    assert {shot.kind for shot in shots} == {"eye", "window"} and {shot.normals is None for shot in shots} == {True, False}
    assert {shot.blur for shot in shots} == {"none", "joint", "separable", "lecture"}
    assert {shot.depth.shape[::-1] for shot in shots if shot.depth is not None} == set(fuzz.SIZES)
    views = [shot.camera.view((16, 12)) for shot in shots]
    assert {view.pinhole for view in views} == {True, False} and {math.isinf(view.far) for view in views} == {True, False}
    assert {view.depth_constants["u_depth_far"] for view in views} == {0.0, 1.0}
    hostile = [shot.depth for shot in shots if shot.depth is not None and not np.isfinite(shot.depth).all()]
    assert 100 < len(hostile) < 1500


def test_blocks_take_turns_over_the_subjects() -> None:
    every = specimens()
    planned = list(fuzz.planned(0, range(len(every) * fuzz.BLOCK), every))
    assert [subject for _, subject in planned[:: fuzz.BLOCK]] == every


def verdict(measure: Callable[[Any], float], exceptions: dict[str, Deviation] | None = None, **more: Any) -> CaseResult:
    """The verdict on a case that needs no OpenGL."""
    declared = exceptions or {}
    subject = SimpleNamespace(
        name="m", preset="default", exceptions=declared, refuses=lambda c: c in declared and math.isinf(declared[c].bound)
    )
    lab = SimpleNamespace(subject=subject, renderer=SimpleNamespace(ctx=SimpleNamespace(provider="p")))
    return judged(Case("c", "g", "promise", "unit", 0.1, measure, **more), lab)[0]  # type: ignore[arg-type]


def failing(error: Exception) -> Callable[[Any], float]:
    def measure(lab: Any) -> float:
        raise error

    return measure


def test_verdicts() -> None:
    declared = {"plane": Deviation(0.5, "so it is defined"), "orthographic": Deviation(math.inf, "perspective only")}
    assert verdict(lambda lab: 0.1).verdict == PASS
    assert verdict(lambda lab: 0.2).verdict == FAIL
    assert verdict(lambda lab: math.nan).verdict == FAIL
    row = verdict(lambda lab: 0.2, declared, contract="plane")
    assert (row.verdict, row.measured, row.declared, row.reason) == (DECLARED, 0.2, 0.5, "so it is defined")
    assert verdict(lambda lab: 0.6, declared, contract="plane").verdict == FAIL
    assert verdict(lambda lab: 0.05, declared, contract="plane").verdict == PASS
    refusal = failing(ao.SettingsError("m: perspective only"))
    assert verdict(refusal, declared, asks=("orthographic",)).verdict == DECLARED
    assert verdict(refusal, declared).verdict == FAIL
    assert verdict(refusal, {"orthographic": Deviation(1, "")}, asks=("orthographic",)).verdict == FAIL
    assert verdict(failing(NotApplicable("nothing there"))).verdict == ABSENT
    assert verdict(failing(Broken("not finite", Shot(lens())))).reason == "not finite"
    assert "unforeseen ZeroDivisionError" in verdict(failing(ZeroDivisionError("x"))).reason


def test_cases_without_a_method_run_once() -> None:
    every = runs(cases().values(), specimens())
    once = [case.name for case, _ in every if case.once]
    assert len(once) == len(set(once)) > 3


def test_a_part_of_an_image_shows_the_same_points() -> None:
    camera = ao.Camera.from_matrix(lens().lens.matrix((20, 15)))
    depth = cast(camera, (20, 15), *room())
    shot = crop(Shot(camera, depth=depth), slice(3, 11), slice(5, 18))
    points = shot.camera.view((13, 8)).points(np.asarray(shot.depth))
    np.testing.assert_allclose(points, camera.view((20, 15)).points(depth)[3:11, 5:18], atol=1e-9)


def test_a_failure_is_made_as_small_as_it_gets() -> None:
    depth = cast(lens(), (32, 24), *room()).astype(np.float32)
    depth[13, 17] = np.inf
    normals = np.ones((24, 32, 3), np.float32)
    shot = Shot(lens(), depth=depth, normals=normals, blur="joint", changes={"bias": 0.1})
    tried = []

    def fails(candidate: Shot) -> bool:
        tried.append(candidate)
        return bool(np.isinf(np.asarray(candidate.depth)).any())

    found = smaller(shot, fails)
    assert found.depth is not None and found.depth.shape == (1, 1) and np.isinf(found.depth).all()
    assert (found.normals, found.blur, found.changes) == (None, "none", {}) and len(tried) < 60


def test_a_failure_keeps_what_it_needs() -> None:
    """Two texels that fail only together, and only filtered."""
    depth = np.full((8, 8), 5, np.float32)

    def fails(candidate: Shot) -> bool:
        z = np.asarray(candidate.depth)
        return z.shape == (8, 8) and z[1, 2] > 0 and z[6, 5] > 0 and candidate.blur == "joint"

    found = smaller(Shot(lens(), depth=depth, blur="joint"), fails)
    assert found.depth is not None and np.count_nonzero(found.depth) == 2 and found.blur == "joint"


def rows() -> report.StressResults:
    results = report.StressResults()
    common: dict[str, Any] = {"group": "g", "preset": "default", "provider": "p", "unit": "u", "bound": 0.1}
    results.add(CaseResult(case="a", method="x", verdict=PASS, measured=0.01, **common))
    results.add(CaseResult(case="a", method="y", verdict=DECLARED, measured=0.3, declared=0.5, reason="as <defined>", **common))
    results.add(
        CaseResult(case="b", method="y", verdict=FAIL, measured=math.nan, reason="bad", command="ssao-gl stress", **common)
    )
    results.add(CaseResult(case="random-7", method="x", verdict=PASS, measured=0, **common))
    results.add(CaseResult(case="random-8", method="x", verdict=FAIL, reason="black", **common))
    return results


def test_results_are_counted_and_laid_out() -> None:
    results = rows()
    assert results.counts() == {PASS: 2, DECLARED: 1, ABSENT: 0, FAIL: 2}
    assert [row.case for row in results.failed] == ["b", "random-8"]
    columns, lines = report.matrix(results.named)
    assert columns == ["case", "x", "y"]
    assert lines == [["a", "0.01", "0.3 <= 0.5 declared"], ["b", "", "FAIL nan"]]


def test_results_as_files(tmp_path: Path) -> None:
    for name in ("r.json", "r.html"):
        report.save_stress_report(tmp_path / name, rows(), {"command": "ssao-gl stress", "p": "a <driver>"})
    data = json.loads((tmp_path / "r.json").read_text())
    assert data["counts"][FAIL] == 2 and len(data["rows"]) == 4 and data["rows"][2]["measured"] is None
    page = (tmp_path / "r.html").read_text()
    assert "as &lt;defined&gt;" in page and "a &lt;driver&gt;" in page and "<script" not in page


def test_unknown_presets_and_methods() -> None:
    with pytest.raises(ao.SettingsError, match="no method has it"):
        specimens(presets=["hihg"])
    with pytest.raises(ao.SettingsError, match="Did you mean 'alchemy'"):
        specimens(["alchemi"])
    assert len(specimens(presets=["all"])) > len(specimens())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "plain"], "Did you mean 'plane'"),
        (["--only", "random-x"], "no such case"),
        (["--seed", "-1"], "must not be negative"),
        (["--cases", "-5"], "must not be negative"),
        (["-o", "results.txt"], "unknown suffix"),
        (["-o", "no/such/folder/r.json"], "there is no folder"),
        (["--replay", "nowhere"], "nowhere/case.json: no such file"),
        (["--methods", "alchemi"], "Did you mean 'alchemy'"),
        (["--gl", "egl-se"], "unknown provider"),
    ],
)
def test_bad_options_get_one_line(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["stress", *arguments])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and message in said and said.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("{", "not JSON"),
        ("[]", "expected an object"),
        ("{}", "not what ssao-gl stress writes"),
        ('{"method": "alchemy", "preset": "default", "settings": [], "whole": true, "case": "plane"}', "not what"),
        ('{"method": "alchemy", "preset": "default", "settings": {}, "whole": true, "case": "x"}', "not what"),
        ('{"method": "alchemy", "preset": "default", "settings": {}, "whole": false, "case": "x", "shots": [{}]}', "not what"),
    ],
)
def test_a_broken_folder_gets_one_line(text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "case.json").write_text(text)
    with pytest.raises(SystemExit) as ended:
        main(["stress", "--replay", str(tmp_path)])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and message in said and said.count("\n") == 1


def test_the_list_needs_no_opengl(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["stress", "--list", "--markdown"])
    assert not ended.value.code and capsys.readouterr().out == case_table.case_table_markdown()
