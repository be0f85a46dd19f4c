"""Volumes on the command line: every command that takes scenes takes them, and bad input gets one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..volumes import ball
from .test_commands import run

nrrd = pytest.importorskip("nrrd")
__all__ = ["run"]
SMALL = ("--size", "48x36")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A ball of 16^3 voxels whose values are distances, 0 on its surface, and a camera file that aims at a level."""
    volume = ball(1.0, 16)
    header = {"space directions": volume.affine[:3, :3].T, "space origin": volume.affine[:3, 3], "space": "RAS"}
    nrrd.write(str(tmp_path / "ball.nrrd"), volume.array, header)
    camera = {"name": "front", "eye": [0, 0, 4], "target": [0, 0, 0], "yfov_deg": 40, "ao_radius": 0.3}
    (tmp_path / "ball.cam.json").write_text(json.dumps({"iso": 0.25, "cameras": [camera]}))
    return tmp_path / "ball.nrrd"


@pytest.mark.gl
def test_every_command_takes_volumes(run: Any, path: Path) -> None:
    assert "volume of 16 x 16 x 16, iso 0.5" in run("render", path, "--iso", "0.5", *SMALL, "-o", "a.npy", "--aov", "depth")
    assert "transfer function bone" in run("render", path, "--transfer", "bone", *SMALL, "-o", "b.png")
    assert "volume of 16 x 16 x 16" in run("explain", path, "--iso", "0.5", *SMALL)
    assert "volume of 16 x 16 x 16" in run("bench", path, "--iso", "0.5", "--rounds", "1", *SMALL)
    run("truth", path, "--iso", "0.5", *SMALL, "--spp", "8", "--no-cache", "-o", "rays")
    seen, rays = np.load("a.npy"), np.load("rays/depth.npy")
    assert (seen > 0).sum() > 100 and np.abs(seen - rays)[(seen > 0) & (rays > 0)].max() < 1e-3


@pytest.mark.gl
@pytest.mark.parametrize(("options", "radius"), [((), 0.75), (("--iso", "0.5"), 0.5)], ids=["camera file", "option"])
def test_reports_take_the_level_of_the_camera_file(run: Any, path: Path, options: tuple[str, ...], radius: float) -> None:
    many = ("--methods", "lecture", "--rounds", "1", "--spp", "4", "--no-reference", "--no-rules", "--cache", "cache")
    run("report", path, *SMALL, *many, *options, "-o", "out")
    (row,) = json.loads(Path("out/results.json").read_text())["rows"]["view"]
    # A ball of that radius, 4 units away, through 40 degrees.
    half = radius / np.sqrt(16 - radius**2) / np.tan(np.radians(20))
    assert abs(row["covered"] - np.pi * half**2 / 4 * 36 / 48) < 0.02


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--iso", "7"), "iso=7: must be above"),
        (("--iso", "nan"), "iso=nan"),
        (("--iso", "0.5", "--transfer", "bone"), "exclude each other"),
        (("--transfer", "bnoe"), "Did you mean 'bone'"),
        (("--frame", "3"), "frame"),
        (("--animation", "walk"), "volume"),
    ],
)
def test_bad_options_get_one_line(capsys: pytest.CaptureFixture[str], path: Path, options: tuple[str, ...], told: str) -> None:
    from ssao_gl.cli import main

    with pytest.raises(SystemExit) as ended:
        main(["render", str(path), *options, "-o", str(path.parent / "x.png")])
    _, err = capsys.readouterr()
    assert ended.value.code == 2 and told in err and err.count("\n") == 1 and "Traceback" not in err
    assert not (path.parent / "x.png").exists()
