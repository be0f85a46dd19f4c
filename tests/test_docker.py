"""The image that renders: its recipe is linted here, and built by .ci/run where there is an engine."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
RECIPE = ROOT / "demos" / "docker" / "Dockerfile"


def test_it_installs_what_renders_and_leaves_root() -> None:
    text = RECIPE.read_text()
    steps = re.findall(r"^([A-Z]+) ", text, re.M)
    assert steps[0] == "FROM" and steps[-2:] == ["ENTRYPOINT", "CMD"]
    assert text.index("apt-get install") < text.index("pip install") < text.index("\nUSER ")
    assert re.search(r"--no-install-recommends libegl1 libgl1-mesa-dri\b", text) and "--no-cache-dir /src" in text
    assert '["ssao-gl"]' in text


def test_what_the_build_needs_is_not_ignored() -> None:
    ignored = RECIPE.with_name("Dockerfile.dockerignore").read_text().split()
    assert not {"ssao_gl", "shaders", "pyproject.toml", "README.md", "LICENSE"} & set(ignored)


def test_the_linter_finds_nothing() -> None:
    beside = Path(sys.executable).with_name("hadolint")
    linter = str(beside) if beside.exists() else shutil.which("hadolint")
    if linter is None:
        pytest.skip("hadolint is not installed here (its wheel is for Linux on x86-64)")
    found = subprocess.run([linter, str(RECIPE)], capture_output=True, text=True, timeout=60, check=False)
    assert found.returncode == 0, found.stdout
