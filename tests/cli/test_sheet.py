"""``ssao-gl sheet``: many scenes in one picture, and what cannot be drawn among them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

import ssao_gl as ao

from ..command_line import refused, run

RED, GREEN = [230, 30, 30, 255], [30, 200, 30, 255]


def ball(path: Path, color: list[int]) -> Path:
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.visual.vertex_colors = color
    mesh.export(path)
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "models"
    made.mkdir()
    ball(made / "a.glb", RED)
    ball(made / "c.ply", GREEN)
    (made / "b.stl").write_bytes(b"no mesh at all")
    (made / "notes.txt").write_text("no scene")
    return made


@pytest.mark.gl
def test_a_sheet_shows_each_file_in_its_place(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report = tmp_path / "sheet.png", tmp_path / "report.json"
    words = ("sheet", folder, "-o", out, "--tile", "48x40", "--columns", 2, "--json", report)
    code, said, err = run(*words, capsys=capsys)
    assert code == 1 and "2 of 3 scenes in 2 columns" in said and "1 could not be drawn" in said
    assert err.count("\n") == 1 and err.startswith(f"ssao-gl: {folder / 'b.stl'}: ")
    pixels = np.asarray(Image.open(out)).astype(int)
    step = (pixels.shape[0] - 8) // 2
    assert pixels.shape == (2 * step + 8, 8 + 2 * 56, 3) and 40 + 8 < step < 80
    first, last = pixels[8 + 20, 8 + 24], pixels[8 + step + 20, 8 + 24]
    assert first[0] > 2 * first[1] and last[1] > 2 * last[0], "files are drawn in the order of their names, row by row"
    broken = pixels[8 : 8 + 40, 64 : 64 + 48]
    assert (broken[0, 0] == (178, 34, 34)).all() and (np.ptp(broken[4:-4, 4:-4], axis=(0, 1)) > 50).any(), "the tile says why"
    names = pixels[8 + 41 : step, 8:56]
    assert np.ptp(names) > 50, "the name stands below"
    found = json.loads(report.read_text())
    assert [Path(entry["file"]).name for entry in found] == ["a.glb", "b.stl", "c.ply"]
    assert "error" in found[1] and found[0]["contents"] == "320 triangles"
    before = out.read_bytes()
    run(*words, capsys=capsys)
    assert out.read_bytes() == before


@pytest.mark.gl
def test_a_folder_gets_a_thumbnail_of_each(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "other"
    other.mkdir()
    ball(other / "a.ply", GREEN)
    out = tmp_path / "thumbs"
    code, said, _ = run(
        "sheet",
        folder / "a.glb",
        other / "a.ply",
        "-o",
        f"{out}/",
        "--tile",
        "32x24",
        "--background",
        "transparent",
        capsys=capsys,
    )
    assert code == 0 and "2 of 2 scenes, 32x24 each" in said
    assert sorted(path.name for path in out.iterdir()) == ["a-2.png", "a.png"], "files of one name are numbered"
    for name, channel in (("a.png", 0), ("a-2.png", 1)):
        pixels = np.asarray(Image.open(out / name))
        assert pixels.shape == (24, 32, 4) and pixels[0, 0, 3] == 0 and pixels[12, 16, 3] == 255
        edge = pixels[(pixels[..., 3] > 0) & (pixels[..., 3] < 255)]
        assert len(edge) > 8 and edge[:, channel].min() > 100, "edges are smooth, and not darkened by what is behind"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "expected files or a folder"),
        (["empty"], "no scene file lies"),
        (["x.glb", "--columns", "0"], "--columns"),
        (["x.glb", "--tile", "wide"], "--tile"),
        (["x.glb", "--up", "w"], "--up"),
        (["x.glb", "--background", "whitish"], "background"),
        (["x.glb", "-o", "x.jpg"], "suffix"),
    ],
)
def test_mistakes_are_told_before_anything_is_drawn(
    words: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path)
    assert says in refused(capsys, "sheet", *words)
    assert [path.name for path in tmp_path.iterdir()] == ["empty"]


@pytest.mark.gl
def test_from_python(tmp_path: Path) -> None:
    things = [trimesh.creation.box(), tmp_path / "missing.glb", ball(tmp_path / "ball.ply", RED)]
    made = ao.sheet(things, tile=(40, 30), columns=3, background="white")
    assert made.image.shape[1] == 8 + 3 * 48 and (made.image[0, 0] == 255).all()
    assert made.report["broken"] == [("missing.glb", "no such file; expected a scene file")]
    with pytest.raises(ao.SettingsError, match="0 scenes"):
        ao.sheet([])
