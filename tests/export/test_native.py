"""The exported C program: Python's bytes on the same driver, and one line for what it cannot use."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.export.pipeline import PipelineInputs
from ssao_gl.export.write import write_export
from ssao_gl.gl.context import Context

from ..conftest import openable
from .cases import CAMERAS, Case, by_effect, settings

pytestmark = pytest.mark.gl
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
HEADERS = Path("/usr/include/GLES3/gl3.h").exists() and Path("/usr/include/EGL/egl.h").exists()


@pytest.fixture(scope="module")
def context() -> ao.gl.Context:
    if COMPILER is None or not HEADERS:
        pytest.skip("no C compiler, or no headers of EGL and GLES: apt-get install gcc libc6-dev libegl-dev libgles-dev")
    if "egl-es" not in openable():
        pytest.skip("EGL gives no OpenGL ES here")
    with ao.gl.open("egl-es") as ctx:
        yield ctx


def compiled(folder: Path, chosen: ao.Settings, given: PipelineInputs) -> Path:
    """Export and compile; return the program."""
    write_export(folder, chosen, given, "gles3")
    strict = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]
    done = subprocess.run(
        [str(COMPILER), *strict, "main.c", "ssao.c", "-lEGL", "-lGLESv2", "-lm", "-o", "ssao"], cwd=folder, capture_output=True, text=True
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder / "ssao"


def write_pfm(path: Path, rows: np.ndarray) -> None:
    """rows: (h, w) or (h, w, 3), row 0 on top."""
    h, w = rows.shape[:2]
    path.write_bytes(b"%s\n%d %d\n-1.0\n" % (b"Pf" if rows.ndim == 2 else b"PF", w, h) + rows[::-1].astype("<f4").tobytes())


def read_netpbm(path: Path) -> np.ndarray:
    """(h, w, channels) uint8, row 0 on top."""
    kind, size, _, data = path.read_bytes().split(b"\n", 3)
    w, h = map(int, size.split())
    return np.frombuffer(data, np.uint8).reshape(h, w, 3 if kind == b"P6" else 1)


def run(program: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(program), *map(str, words)], cwd=program.parent, capture_output=True, text=True, timeout=60)


def drawn(program: Path, case: Case, *words: str) -> np.ndarray:
    """What the program draws of a case."""
    folder, out = program.parent, "out.ppm" if case.color else "out.pgm"
    write_pfm(folder / "depth.pfm", case.depth)
    projection = CAMERAS[case.camera].view(case.size).projection.T.ravel()
    more: list[object] = []
    if case.normals:
        write_pfm(folder / "normals.pfm", case.normal[..., :3])
        more += ["--normals", "normals.pfm"]
    if case.color:
        (folder / "color.ppm").write_bytes(b"P6\n%d %d\n255\n" % case.size + case.picture[..., :3].tobytes())
        more += ["--color", "color.ppm"]
    done = run(program, "depth.pfm", out, "--projection", *(repr(float(v)) for v in projection), *more, *words)
    assert (done.returncode, done.stderr) == (0, "")
    return read_netpbm(folder / out)


DRAWN = {
    "bitmask medium": (settings("bitmask", "medium"), Case("perspective", (161, 91))),
    "bitmask reversed": (settings("bitmask", "draft"), Case("reversed infinite", (96, 54))),
    "alchemy with all": (settings("alchemy"), Case("off-centre", (96, 55), normals=True, color=True)),
    "gtao parallel": (settings("gtao"), Case("orthographic", (96, 54), depth_kind="eye")),
    "lecture": (settings("lecture"), Case("perspective", (80, 45))),
    "vom": (settings("vom"), Case("perspective", (63, 41))),
}


@pytest.mark.parametrize("name", DRAWN)
def test_the_program_draws_pythons_bytes(context: Context, tmp_path: Path, name: str) -> None:
    chosen, case = DRAWN[name]
    program = compiled(tmp_path, chosen, PipelineInputs(case.depth_kind, case.normals, case.color))
    found = drawn(program, case)
    with ao.Effect(context, case.size, chosen) as effect:
        expected = by_effect(context, effect, case)[..., : found.shape[2]]
    assert expected[..., 0].std() > 5
    assert np.array_equal(found, expected)


@pytest.fixture(scope="module")
def program(context: Context, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = compiled(tmp_path_factory.mktemp("native"), settings("alchemy"), PipelineInputs())
    write_pfm(made.parent / "depth.pfm", Case("perspective", (32, 24)).depth)
    (made.parent / "not.pfm").write_bytes(b"P5\n1 1\n255\n0")
    return made


def test_its_settings_change(context: Context, program: Path) -> None:
    case = Case("perspective", (48, 32))
    wide, narrow = (drawn(program, case, f"radius={radius}").astype(int) for radius in (1.0, 0.3))
    assert narrow.mean() > wide.mean() + 1


MISTAKES = {
    "": "usage: ssao",
    "gone.pfm out.pgm": "gone.pfm: expected a PFM file",
    "not.pfm out.pgm": "not.pfm: expected a PFM file",
    "depth.pfm out.pgm --shaders gone": "cannot read the shader gone/",
    "depth.pfm out.pgm --what": "--what: unknown option",
    "depth.pfm out.pgm --yfov-deg 1": "--yfov-deg: unknown option, or too few",
    "depth.pfm out.pgm radius=-1": "radius=-1: is out of range",
    "depth.pfm out.pgm radios=1": "'radios' cannot change",
    "depth.pfm out.pgm --normals depth.pfm": "three channels",
    "depth.pfm gone/out.pgm": "cannot be written",
    "depth.pfm out.pgm --projection 1 0 0 0 0 1 0 0 0 0 -1 1 0 0 -1 0": "looks along +z",
    "depth.pfm out.pgm --projection 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0": "flattens the image",
}


@pytest.mark.parametrize("words", MISTAKES)
def test_it_says_in_one_line_what_is_wrong(program: Path, words: str) -> None:
    done = run(program, *words.split())
    assert done.returncode == 2
    assert MISTAKES[words] in done.stderr
    assert done.stderr.count("\n") == 1 or not words
