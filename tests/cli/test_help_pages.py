"""Help that fits on a page, and what it leaves out on request."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.cli.help_pages import COMMANDS
from ssao_gl.methods.registry import registry
from tests.command_line import run


def page(*words: str, columns: int = 100) -> str:
    """What a command prints."""
    environment = {**os.environ, "COLUMNS": str(columns)}
    ran = subprocess.run([sys.executable, "-m", "ssao_gl", *words], env=environment, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_commands_on_a_line_each_with_three_examples() -> None:
    out = page("-h")
    assert "planner" not in out
    for name, (_, about) in COMMANDS.items():
        (line,) = [line for line in out.splitlines() if line.strip("│ ").startswith(f"{name} ")]
        assert about.splitlines()[0] in line
    assert out.count("\n  ssao-gl ") == 3


def test_render_fits_sixty_lines() -> None:
    """Rare options are named, and described by --help-all."""
    for columns in (80, 100):
        short = page("render", "-h", columns=columns)
        assert len(short.splitlines()) <= 60 and max(map(len, short.splitlines())) <= columns
    assert "--crease-deg" in short and "edges sharper" not in short and "ssao-gl methods NAME" in short
    assert "edges sharper" in page("render", "--help-all")
    assert page("help", "render") == short


def test_all_help_is_for_one_call(capsys: pytest.CaptureFixture[str]) -> None:
    short = run("render", "-h", capsys=capsys)
    assert len(run("render", "--help-all", capsys=capsys)[1]) > len(short[1])
    assert run("render", "-h", capsys=capsys) == short


@pytest.mark.parametrize("name", [*registry(), "joint", "shading", "picture"])
def test_methods_tells_every_setting(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(run("methods", name, "--json", capsys=capsys)[1])
    _, out, _ = run("methods", name, capsys=capsys)
    for about in found.values():
        assert about["settings"] and all(one["about"] for one in about["settings"])
        for one in about["settings"]:
            rows = [line.split("│") for line in out.splitlines() if line.startswith(f"│ {one['name']} ")]
            shown = (
                "auto"
                if one["default"] is None
                else f"{one['default']:.6g}"
                if isinstance(one["default"], float)
                else one["default"]
            )
            assert any(row[2].strip() == str(shown) and one["range"] in row[4] for row in rows), one
        for preset in about["presets"]:
            assert f"--preset {preset}: " in out


@pytest.mark.gl
def test_doctor_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run("doctor", "--json", capsys=capsys)
    found = json.loads(out)
    assert found["works"] and set(found["providers"]) >= {"egl-es", "osmesa", "native"}
    for one in found["providers"].values():
        assert one["largest_texture"] > 0 if one["works"] else one["reason"] and one["cure"]


def test_completion_is_installed(tmp_path: Path) -> None:
    """For bash, into the user's home."""
    environment = {**os.environ, "HOME": str(tmp_path), "SHELL": "/bin/bash"}
    command = [sys.executable, "-m", "ssao_gl", "--install-completion"]
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stderr
    (script,) = [path for path in tmp_path.rglob("*ssao-gl*") if path.is_file()]
    text = script.read_text()
    assert "render" in text and "--method" in text


def test_version() -> None:
    assert ao.__version__.split(".")[0].isdigit()
