"""Methods of other packages: one Python file and one shader, with no edit anywhere else."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[2] / "demos" / "guide" / "add_a_method.md"

METHOD = '''
"""Glow: an example of a method of another package."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ssao_gl.graph.names import DEPTH
from ssao_gl.settings import setting, validate


@dataclass(frozen=True, slots=True, kw_only=True)
class Glow:
    """Visibility that falls with depth; after Nobody, "Glow", 2026."""

    name: ClassVar[str] = "glow"
    shader: ClassVar[str] = "glow.frag"

    radius: float | None = setting(None, "reach of occlusion", unit="scene units", above=0)
    gain: float = setting(0.5, "visibility of what is seen", low=0, high=1)
    steps: str = setting("none", "a word, where other methods have a number")
    scale: str = setting("plain", "likewise")

    def __post_init__(self) -> None:
        validate(self)

    @property
    def samplers(self) -> Mapping[str, str]:
        return {"u_z": DEPTH}

    def defines(self) -> Mapping[str, Any]:
        return {}

    def constants(self) -> Mapping[str, Any]:
        return {"u_gain": self.gain}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, Any]:
        return {}
'''

SHADER = """
#include "lib/view.glsl"
#include "lib/output.glsl"
#include "glow_gain.glsl"
uniform sampler2D u_z;

void main() {
    float z = SAMPLE(u_z, gl_FragCoord.xy * u_texel).r;
    ssao_write(u_gain, z);
}
"""

BROKEN = "import no_such_module_anywhere\n"


def installed(folder: Path, package: str, files: dict[str, str], entries: str) -> None:
    """A package as pip leaves it: its files, and what it says of itself."""
    place = folder / package
    place.mkdir()
    for name, text in files.items():
        (place / name).write_text(text)
    about = folder / f"{package}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[ssao_gl.methods]\n{entries}\n")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    files = {"__init__.py": METHOD, "glow.frag": SHADER, "glow_gain.glsl": "uniform float u_gain;\n"}
    installed(folder, "glowing", files, "glow = glowing:Glow")
    installed(folder, "breaking", {"__init__.py": BROKEN}, "break = breaking:Break")
    return folder


def run(site: Path, *words: object) -> subprocess.CompletedProcess[str]:
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH")]), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=300, env=environment)


def command(site: Path, *words: object) -> str:
    done = run(site, "-m", "ssao_gl", *words)
    assert done.returncode == 0, done.stderr
    assert "the AO method break (breaking:Break) cannot be used: ModuleNotFoundError" in done.stderr, "and is left out"
    return done.stdout


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory, site: Path) -> tuple[Path, Path]:
    """The package of the guide's page, as it stands there, and the folder into which its wheel is installed; a broken one beside it."""
    source, target = tmp_path_factory.mktemp("package"), tmp_path_factory.mktemp("target")
    blocks = re.findall(r"^`([\w./]+)`, [^\n]*:\n\n```\w+\n(.*?)```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    for name, text in blocks:
        (source / name).parent.mkdir(exist_ok=True)
        (source / name).write_text(text)
    assert [name for name, _ in blocks] == [
        *("pyproject.toml", "ssao_gl_cavity/__init__.py", "ssao_gl_cavity/cavity.frag", "tests/test_cavity.py")
    ]
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--target", target]
    subprocess.run([sys.executable, "-m", "pip", "install", *map(str, options), str(source)], check=True, timeout=300)
    assert (target / "ssao_gl_cavity" / "cavity.frag").is_file(), "the wheel carries the shader"
    installed(target, "breaking", {"__init__.py": BROKEN}, "break = breaking:Break")
    return source, target


@pytest.mark.gl
def test_the_page_of_the_guide_makes_a_method(followed: tuple[Path, Path], tmp_path: Path) -> None:
    _, target = followed
    assert "cavity" in command(target, "methods")
    picture = tmp_path / "a.npy"
    command(target, "render", "--method", "cavity", "--size", "64x48", "-o", picture)
    visibility = np.load(picture)
    assert visibility.std() > 0.02 and visibility.max() == 1
    assert "cavity" in command(target, "explain", "--method", "cavity")
    words = [
        "--methods",
        "cavity,alchemy",
        "--presets",
        "low",
        "--size",
        "64x48",
        "--spp",
        "4",
        "--rounds",
        "1",
        "--fit",
        "none",
    ]
    command(target, "report", *words, "--no-reference", "--cache", tmp_path / "cache", "-o", tmp_path / "report")
    assert "cavity" in (tmp_path / "report" / "report.md").read_text()


@pytest.mark.gl
def test_the_method_of_the_page_keeps_its_promises(followed: tuple[Path, Path], tmp_path: Path) -> None:
    """Those of ``ssao_gl.testing``, by the page's own test, and every case of the stress test."""
    source, target = followed
    ran = run(target, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", source, source / "tests")
    assert re.search(r"^10 passed", ran.stdout, re.MULTILINE), ran.stdout[-3000:]
    out = tmp_path / "stress.json"
    command(target, "stress", "--methods", "cavity", "--failures", tmp_path / "failures", "-o", out)
    verdicts = {row["verdict"] for row in json.loads(out.read_text())["rows"]}
    assert "pass" in verdicts and "FAIL" not in verdicts


def test_a_broken_package_does_not_silence_the_version(site: Path) -> None:
    import ssao_gl

    done = run(site, "-m", "ssao_gl", "--version")
    assert (done.returncode, done.stdout.strip()) == (0, ssao_gl.__version__)
    told = [line for line in run(site, "-m", "ssao_gl", "methods").stderr.splitlines() if "break" in line]
    assert len(told) == 1, "in one line"


@pytest.mark.gl
def test_the_command_line_knows_it_and_draws_it(site: Path, tmp_path: Path) -> None:
    """Its fields called ``steps`` and ``scale`` are its own business; the shader lies beside its module and includes ours."""
    assert "glow" in command(site, "methods")
    picture = tmp_path / "a.npy"
    command(site, "render", "--method", "glow", "--blur", "none", "--set", "gain=0.2", "--size", "64x48", "-o", picture)
    visibility = np.load(picture)
    assert set(np.unique(visibility).tolist()) == {float(np.float16(0.2)), 1.0}


@pytest.mark.gl
def test_stress_and_the_contract_tests_ask_it(site: Path, tmp_path: Path) -> None:
    out = tmp_path / "stress.json"
    chosen = ["--only", "plane,infinite-far", "--failures", tmp_path / "failures"]
    done = run(site, "-m", "ssao_gl", "stress", "--methods", "glow", *chosen, "-o", out)
    rows = {row["case"]: row for row in json.loads(out.read_text())["rows"]}
    assert done.returncode == 1 and rows["infinite-far"]["verdict"] == "pass", done.stderr
    assert rows["plane"]["verdict"] == "FAIL" and rows["plane"]["method"] == "glow", "it is grey, and does not say so"
    root = Path(__file__).parents[2]
    collected = run(site, "-m", "pytest", "--collect-only", "-q", "-k", "glow", root / "tests", "-p", "no:cacheprovider")
    assert re.search(r"contract/test_methods\.py: \d\d+", collected.stdout), collected.stdout[-2000:]


@pytest.mark.gl
def test_the_report_measures_it(site: Path, tmp_path: Path) -> None:
    words = ["--methods", "glow,alchemy", "--presets", "low", "--size", "64x48", "--spp", "4", "--rounds", "1", "--fit", "none"]
    command(site, "report", *words, "--no-reference", "--cache", tmp_path / "cache", "-o", tmp_path / "report")
    assert "glow" in (tmp_path / "report" / "report.md").read_text()
