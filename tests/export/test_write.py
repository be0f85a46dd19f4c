"""Exports as files: what each target gets, how small it is, and one line for what cannot be exported."""

from __future__ import annotations

import dataclasses
import gzip
import json
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.errors import FormatError, SettingsError
from ssao_gl.export.write import RUNTIME, small_module

from ..command_line import refused, run

METHOD = ao.Bitmask(radius=0.3)
NAMES = {
    "webgl2": {"pipeline.js", "pipeline.d.ts", "ssao-gl.js", "ssao-gl.d.ts"},
    "json": {"pipeline.json", "pipeline.schema.json"},
    "gles3": {"pipeline.h", "ssao.h", "ssao.c", "view.h", "main.c", "shaders/fullscreen.vert", "shaders/00-linearize.frag"},
}


@pytest.mark.parametrize("target", NAMES)
def test_each_target_gets_its_files_and_the_same_bytes_again(tmp_path: Path, target: str) -> None:
    files = ao.export(tmp_path / "out", target=target, method=METHOD)
    assert {path.relative_to(tmp_path / "out").as_posix() for path in files} >= NAMES[target]
    before = [path.read_bytes() for path in files]
    assert [path.read_bytes() for path in ao.export(tmp_path / "out", target=target, method=METHOD)] == before
    assert sorted(path for path in (tmp_path / "out").rglob("*") if path.is_file()) == sorted(files)


def test_runtime_and_default_pipeline_take_at_most_12_kb(tmp_path: Path) -> None:
    ao.export(tmp_path, method=METHOD)
    both = b"".join((tmp_path / name).read_bytes() for name in ("ssao-gl.js", "pipeline.js"))
    assert len(gzip.compress(both, 9)) <= 12000


def test_a_module_loses_comments_and_no_code() -> None:
    small = small_module(RUNTIME.read_text("utf-8"))
    assert "// Inverse" not in small and "export class SsaoGl" in small
    assert small_module("// why\nconst a = [\n    1,\n];\nf(a); // so\nif (a) g()\n").splitlines()[1:] == [
        "const a = [1,];f(a);if (a) g()"
    ]


def test_mistakes_say_what_is_wrong(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="give bitmask a radius"):
        ao.export(tmp_path)
    with pytest.raises(SettingsError, match=r"target 'webgl'.*Did you mean 'webgl2'"):
        ao.export(tmp_path, method=METHOD, target="webgl")
    with pytest.raises(SettingsError, match="depth kind 'ray'"):
        ao.export(tmp_path, method=METHOD, depth_kind="ray")
    with pytest.raises(SettingsError, match="needs a scene"):
        ao.export(tmp_path, method=dataclasses.replace(ao.method("baked"), radius=1.0))
    (tmp_path / "file").write_text("here")
    with pytest.raises(FormatError):
        ao.export(tmp_path / "file", method=METHOD)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_the_command_writes_what_it_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--method", "gtao", "--preset", "low", "--radius", "0.4", "--color", "--strength", "0.5", "--target", "json"]
    code, out, _ = run("export", *words, "-o", tmp_path / "out", capsys=capsys)
    assert code == 0 and "pipeline.json" in out
    made = json.loads((tmp_path / "out" / "pipeline.json").read_text())
    assert made["settings"]["gtao"]["slices"] == 1
    assert (made["live"]["radius"]["value"], made["live"]["strength"]["value"]) == (0.4, 0.5)
    assert "give a length" in refused(capsys, "export", "--radius", "5%", "-o", tmp_path / "no")
    assert "webgl2" in refused(capsys, "export", "--radius", "1", "--target", "web", "-o", tmp_path / "no")
    assert not (tmp_path / "no").exists()
