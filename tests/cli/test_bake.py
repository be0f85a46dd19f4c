"""``ssao-gl bake``, as people type it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ..command_line import refused, run
from ..scene_files import glb, stl, tree

TRIANGLES = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 0, 1], [1, 0, 0]]]


@pytest.fixture
def corner(tmp_path: Path) -> Path:
    path = tmp_path / "corner.stl"
    path.write_bytes(stl(TRIANGLES))
    return path


def test_a_file_and_what_is_said_of_it(corner: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report, cache = tmp_path / "out.glb", tmp_path / "report.json", tmp_path / "cache"
    words = ("bake", corner, "-o", out, "--radius", "50%", "--spp", 16, "--json", report, "--cache", cache)
    code, said, _ = run(*words, capsys=capsys)
    assert code == 0 and "1 mesh, 6 vertices" in said and "16 rays each" in said
    found = json.loads(report.read_text())
    assert found["settings"]["vertices"] == {"attribute": "COLOR_0"} and found["meshes"][0]["mean_visibility"] < 0.9
    first = out.read_bytes()
    code, said, _ = run(*words, capsys=capsys)
    assert "from the cache" in said and out.read_bytes() == first


def test_arrays_and_textures(corner: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "arrays"
    assert run("bake", corner, "-o", folder, "--no-cache", capsys=capsys)[0] == 0
    assert [np.load(path).shape for path in folder.iterdir()] == [(6,)]
    out = tmp_path / "out.glb"
    code, said, _ = run("bake", corner, "-o", out, "--to", "texture", "--size", 64, "--no-cache", capsys=capsys)
    assert code == 0 and "1 texture of 64x64" in said and out.read_bytes().startswith(b"glTF")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "x.gltf"], ".glb"),
        (["-o", "x.glb", "--spp", "0"], "spp"),
        (["-o", "x.glb", "--spp", "1.5"], "whole number"),
        (["-o", "x.glb", "--radius", "-1"], "radius"),
        (["-o", "x.glb", "--radius", "wide"], "radius"),
        (["-o", "x.glb", "--radius", "1e-30"], "too small"),
        (["-o", "x.glb", "--attribute", "AO"], "begin with _"),
        (["-o", "x.glb", "--sides", "back"], "sides"),
        (["-o", "x.glb", "--falloff", "hrad"], "Did you mean 'hard'"),
        (["-o", "x.glb", "--size", "64"], "--to texture"),
        (["-o", "x.glb", "--to", "texture", "--attribute", "_AO"], "--to vertices"),
        (["-o", "x.glb", "--to", "texture", "--size", "9999"], "size"),
        (["-o", "x.glb", "--to", "texture", "--unwrap", "never"], "texture coordinates"),
        (["-o", "x.glb", "--to", "texels"], "texture"),
        (["-o", "x.glb", "--time", "1"], "--animation"),
        (["-o", "x.glb", "--animation", "walk"], "no animations"),
        (["-o", "-", "--json", "-"], "only one"),
        (["-o", "no/such/folder/x.glb"], "no/such"),
        ([], "--output"),
    ],
)
def test_mistakes_are_one_line(
    words: list[str],
    says: str,
    corner: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert says in refused(capsys, "bake", corner, "--no-cache", *words)
    assert [path.name for path in tmp_path.iterdir()] == ["corner.stl"]


@pytest.mark.parametrize("content", [b"", b"glTF", b"solid nothing", glb(tree(), b"")[:-4]])
@pytest.mark.parametrize("suffix", ["glb", "stl"])
def test_broken_scenes_are_one_line(content: bytes, suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / f"broken.{suffix}"
    path.write_bytes(content)
    assert str(path) in refused(capsys, "bake", path, "-o", tmp_path / "out.glb", "--no-cache")
    assert not (tmp_path / "out.glb").exists()


def test_notes_are_errors_on_demand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "odd.glb"
    path.write_bytes(glb(tree(extensionsUsed=["EXT_of_nobody"])))
    code, _, said = run("bake", path, "-o", tmp_path / "out.glb", "--no-cache", "--strict", capsys=capsys)
    assert code == 2 and said.endswith("EXT_of_nobody (--strict)\n")
    assert not (tmp_path / "out.glb").exists()


def test_by_elements(corner: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("numba")
    code, said, _ = run(
        "bake", corner, "-o", tmp_path / "e.glb", "--by", "elements", "--radius", "50%", "--no-cache", capsys=capsys
    )
    assert code == 0 and "by elements, 4 passes" in said and "rays" not in said


def test_elements_refuse_what_they_do_not_know(corner: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("bake", corner, "-o", tmp_path / "e.glb", "--by", "elements", "--falloff", "quadratic")
    assert "elements know a hard radius only" in refused(capsys, *words)
