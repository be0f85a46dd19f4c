"""The planner's commands: fitting the table of errors, and checking plans; and the speed of rays."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh

from ssao_gl.cli import main
from ssao_gl.planner.candidates import CANDIDATES
from ssao_gl.planner.error_model import SIGNS

SIZE = ("--size", "32x24")
CAMERA = {"name": "front", "eye": [2.5, 2.0, 3.0], "target": [0, 0, 0], "up": [0, 1, 0], "yfov_deg": 40, "ao_radius": 0.5}


@pytest.fixture
def scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Two scene files, each a corner that occludes itself, with a camera beside it."""
    monkeypatch.chdir(tmp_path)
    names = []
    for name, height in (("low", 0.6), ("high", 1.4)):
        floor = trimesh.creation.box(extents=(2, 0.2, 2))
        block = trimesh.creation.box(
            extents=(0.8, height, 0.8), transform=trimesh.transformations.translation_matrix([0, height / 2, 0])
        )
        trimesh.util.concatenate([floor, block]).export(f"{name}.glb")
        Path(f"{name}.cam.json").write_text(json.dumps({"cameras": [CAMERA]}))
        names.append(f"{name}.glb")
    return names


def run(capsys: pytest.CaptureFixture[str], *arguments: object, code: int = 0) -> tuple[str, str]:
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert (ended.value.code or 0) == code, err
    return out, err


@pytest.mark.gl
def test_fit_goes_on_and_says_the_same(scenes: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """A table for every candidate; the second run measures nothing and writes the same bytes."""
    command = ("planner", "fit", *scenes, *SIZE, "--rows", "rows.json", "-o", "errors.json")
    out, _ = run(capsys, *command)
    assert "low.glb:front 32x24 radius x0.5\n" in out and "high.glb:front 32x24 radius x2\n" in out
    table = Path("errors.json").read_bytes()
    made = json.loads(table)
    assert set(made) == {str(layers) for layers in SIGNS}
    assert set(made["2"]) == {candidate.name for _, candidate in CANDIDATES.values()}
    assert all(weight >= 0 for one in made["2"].values() for weight in one["weights"].values())
    again, _ = run(capsys, *command)
    assert "radius x" not in again and Path("errors.json").read_bytes() == table


@pytest.mark.gl
def test_check_tells_of_every_candidate(scenes: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """A line for the view, lines about all, and every candidate in the file."""
    out, _ = run(capsys, "planner", "check", scenes[0], *SIZE, "--json", "found.json")
    assert out.startswith("low.glb:front: time off by ") and "error of the choice within a budget" in out
    rows = json.loads(Path("found.json").read_text())
    assert rows and all(row["view"] == "low.glb:front" and row["ms"] > 0 for row in rows)


def test_fit_refuses(scenes: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """One scene cannot be predicted by the others; rows of something else are no rows, and are left alone."""
    assert "at least two" in run(capsys, "planner", "fit", scenes[0], code=2)[1]
    Path("rows.json").write_text('{"a": [{"b": 1}]}')
    _, err = run(capsys, "planner", "fit", *scenes, "--rows", "rows.json", code=2)
    assert "rows.json: not the rows" in err and err.count("\n") == 1
    assert Path("rows.json").read_text() == '{"a": [{"b": 1}]}' and not Path("errors.json").exists()


def test_check_refuses_no_scene(capsys: pytest.CaptureFixture[str]) -> None:
    """There is nothing to check without a scene."""
    assert "at least one scene" in run(capsys, "planner", "check", code=2)[1]


def test_speed_of_rays(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Speeds by number of threads; no file."""
    monkeypatch.chdir(tmp_path)
    out, _ = run(capsys, "truth", "--bench", *SIZE, "--spp", "16")
    assert out.startswith("1 thread: embreex ") and "million rays/s" in out
    assert not list(tmp_path.iterdir())
