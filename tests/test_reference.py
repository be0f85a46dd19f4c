"""The reference of public names builds without a warning, and the gallery by one command."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import ssao_gl as ao

from .packages import needed

ROOT = Path(__file__).parents[1]


def test_every_public_name_is_described(tmp_path: Path) -> None:
    needed("pdoc")
    command = [sys.executable, str(ROOT / ".ci" / "api-reference"), str(tmp_path)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert built.returncode == 0 and "Warn" not in built.stderr, built.stderr
    page = (tmp_path / "ssao_gl.html").read_text("utf-8")
    described = set(re.findall(r'<section id="(\w+)">', page))
    assert set(ao.__all__) - {"gl"} <= described, set(ao.__all__) - described
    for name in set(ao.__all__) - {"gl"}:
        assert (getattr(ao, name).__doc__ or "").strip(), f"ssao_gl.{name} says nothing of itself"


@pytest.mark.gl
def test_the_gallery_shows_what_a_demo_made(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "demos" / "gallery.py"), "-o", str(tmp_path), "--size", "96x54", "--only", "02"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stderr
    page = (tmp_path / "index.html").read_text("utf-8")
    shown = re.findall(r'<img src="([^"]+)"', page)
    assert shown == ["02_numpy.png", "02_visibility.png"] and all((tmp_path / name).is_file() for name in shown)
    assert "Arrays in, arrays out" in page
