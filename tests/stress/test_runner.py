"""The stress battery in its short form, on every provider; and that it catches what is broken."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.cli import main
from ssao_gl.glsl import preprocess
from ssao_gl.methods import registry as methods
from ssao_gl.methods.alchemy import Alchemy
from ssao_gl.methods.registry import general, method, registry
from ssao_gl.stress.catalogue import cases
from ssao_gl.stress.fuzz import BLOCK, planned, random_shot
from ssao_gl.stress.replay import Recorder, replayed
from ssao_gl.stress.runner import Broken, CaseRunner
from ssao_gl.stress.shapes import lens, plane
from ssao_gl.stress.shot import Shot
from ssao_gl.stress.specimen import Specimen, specimens
from ssao_gl.stress.verdicts import ABSENT, DECLARED, FAIL, PASS, CaseResult, run_cases, runs

from ..conftest import openable


@pytest.fixture(scope="module")
def wide(provider: str) -> Iterator[ao.Renderer]:
    """A renderer that keeps many plans, as the command has."""
    with ao.Renderer(provider, keep=32) as made:
        yield made


@pytest.fixture(scope="module")
def first() -> Iterator[Any]:
    """Opens the renderer that others are compared with, when it is asked for."""
    made: list[ao.Renderer] = []

    @cache
    def opened() -> ao.Renderer:
        made.append(ao.Renderer(openable()[0], keep=32))
        return made[0]

    yield opened
    for one in made:
        one.release()


def failures(rows: list[CaseResult]) -> list[str]:
    return [f"{row.case}: {row.measured} over {row.bound}, {row.reason}" for row in rows if row.verdict == FAIL]


SLOW = {name for name in general() if ao.method(name).traits.needs_scene}
"""Methods that make something of the scene for every case: a minute for each driver. On the first here; ``ssao-gl stress --gl all`` has all."""


@pytest.mark.parametrize("name", general())
def test_every_named_case(wide: ao.Renderer, first: Any, name: str) -> None:
    if name in SLOW and wide.ctx.provider not in openable()[:1]:
        pytest.skip("minutes: on the first driver here, on all by ssao-gl stress --gl all")
    rows = list(run_cases(wide, runs(cases().values(), specimens([name])), first))
    assert len(rows) == len(cases()) and failures(rows) == []
    verdicts = Counter(row.verdict for row in rows)
    absent = verdicts[ABSENT] if ao.method(name).traits.needs_scene else 0  # of those that draw depth images
    assert verdicts[PASS] > max(len(rows) - absent, 60) / 2


def test_random_cases(wide: ao.Renderer) -> None:
    every = specimens()
    rows = list(run_cases(wide, planned(0, range(2 * BLOCK * len(every)), every)))
    assert failures(rows) == [] and {row.verdict for row in rows} <= {PASS, DECLARED}


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Zero(Alchemy):
    """Divides by zero at every texel that is exactly 3 units away. Made for this test in 2026."""

    name: ClassVar[str] = "broken"
    shader: ClassVar[str] = "methods/broken.frag"


@pytest.fixture
def broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A registered method whose shader is the one of alchemy with a division by zero; yields the shader's path."""
    folder = tmp_path / "shaders"
    shutil.copytree(preprocess.root(), folder)
    text = (folder / "methods/alchemy.frag").read_text()
    shader = folder / "methods/broken.frag"
    shader.write_text(text.replace("    ssao_write(", "    open += 1.0 / (z - 3.0);\n    ssao_write("))
    assert shader.read_text() != text
    monkeypatch.setenv("SSAO_GL_SHADERS", str(folder))
    monkeypatch.setattr(methods, "_METHODS", {**methods._METHODS, "broken": Zero})
    forget()
    yield shader
    monkeypatch.undo()
    forget()


def forget() -> None:
    """What was read of shaders and methods is read anew."""
    for cached in (preprocess.root, preprocess._read, registry):
        cached.cache_clear()


def spoilt(lab: CaseRunner) -> float:
    """A tilted plane with one texel exactly 3 units away."""
    depth = np.linspace(4, 6, 64 * 48, dtype=np.float32).reshape(48, 64)
    depth[20, 33] = 3
    return lab.apply(depth, lens(), normals=np.full((48, 64, 3), 1.0)).darkest * 0


def test_a_broken_method_is_caught_reduced_and_replayed(provider: str, broken: Path, tmp_path: Path) -> None:
    found = method("broken")
    subject = Specimen("broken", "default", dataclasses.replace(found, bias=0.0))
    case = dataclasses.replace(cases()["plane"], name="spoilt", measure=spoilt)
    with ao.Renderer(provider) as renderer:
        (row,) = run_cases(renderer, [(case, subject)], failed=Recorder(renderer, tmp_path / "failures", 0))
    assert (row.verdict, row.reason) == (FAIL, "method or filter compute NaN or infinity at 1 pixels")
    folder = Path(row.folder)
    depth = np.load(folder / "1-depth.npy")
    assert depth.shape == (1, 1) and depth[0, 0] == 3
    content = json.loads((folder / "case.json").read_text())
    assert content["settings"]["bias"] == 0 and content["shots"][0]["blur"] == "none"
    assert row.command == f"ssao-gl stress --gl {provider} --replay {folder}"
    with pytest.raises(SystemExit) as ended:
        main(row.command.split()[1:])
    assert ended.value.code == 1
    broken.write_text(broken.read_text().replace("1.0 / (z - 3.0)", "0.0"))  # the cure
    forget()
    with ao.Renderer(provider) as renderer:
        assert replayed(renderer, folder).verdict == PASS


def test_a_case_that_fails_as_a_whole_is_replayed_by_its_name(provider: str, tmp_path: Path) -> None:
    subject = specimens(["alchemy"])[0]
    tight = dataclasses.replace(cases()["grid-shift"], bound=-1.0)
    with ao.Renderer(provider) as renderer:
        (row,) = run_cases(renderer, [(tight, subject)], failed=Recorder(renderer, tmp_path, 0))
        assert row.verdict == FAIL and row.command == f"ssao-gl stress --gl {provider} --methods alchemy --only grid-shift"
        assert len(list(Path(row.folder).glob("*-depth.npy"))) == 2
        assert replayed(renderer, Path(row.folder)).verdict == PASS  # by the bound that the case really has


def test_nothing_hides_behind_a_clamp(any_renderer: ao.Renderer) -> None:
    """A strength that is not a number comes out as some number in 0..1, by minima and maxima; it is seen all the same."""

    class Poisoned(Alchemy):
        def constants(self) -> Mapping[str, Any]:
            return {**super().constants(), "u_strength": float("nan")}

    subject = Specimen("alchemy", "default", Poisoned())
    shot = Shot(lens(), plane(0.5), size=(16, 12))
    seen = any_renderer.render(shot.scene, shot.camera, (16, 12), subject.settings(shot), aovs=("visibility",))  # type: ignore[arg-type]
    assert np.isin(seen.visibility, (0, 1)).all()
    with pytest.raises(Broken, match="NaN or infinity at 192 pixels"):
        CaseRunner(any_renderer, subject).see(shot)


def test_a_random_case_is_drawn_alike_twice(any_renderer: ao.Renderer) -> None:
    (subject,) = specimens(["bitmask"])
    for number in range(3):
        first, second = (CaseRunner(any_renderer, subject).see(random_shot(7, number, subject)).visibility for _ in range(2))
        np.testing.assert_array_equal(first, second)


def test_the_command(
    provider: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["--gl", provider, "--methods", "alchemy,lecture", "--only", "plane,infinite-far,random-3", "--cases", "4"]
    with pytest.raises(SystemExit) as ended:
        main(["stress", *words, "-o", "r.json"])
    said = capsys.readouterr().out
    assert not ended.value.code and "plane" in said and "refuses, declared" in said
    data = json.loads(Path("r.json").read_text())
    assert sum(data["counts"].values()) == 2 * 3 + 4 and data["counts"][FAIL] == 0
    assert not Path("stress-failures").exists()
