"""Faults from outside: a driver without memory, a lost context, broken shader files, a full disk, Ctrl-C, kill -9, two runs at once.

Each gives one clear line or nothing at all; what is on the disk is whole; the next run goes on as if nothing had been.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.errors import ContextError
from ssao_gl.glsl import preprocess
from ssao_gl.io import images
from ssao_gl.io.atomic import locked_folder

from .. import shapes

SMALL = ("--size", "48x32")


def command(*arguments: object, environment: dict[str, str] | None = None, limit: int | None = None) -> subprocess.Popen[str]:
    """``ssao-gl`` in a process of its own that heeds Ctrl-C; ``limit``: bytes that a file may have, as on a full disk."""

    def prepare() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # ignored by what a background shell starts
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    line = [sys.executable, "-m", "ssao_gl", *map(str, arguments)]
    return subprocess.Popen(
        line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=prepare, env={**os.environ, **(environment or {})}
    )  # fmt: skip


def ended(running: subprocess.Popen[str], code: int = 0) -> str:
    """Standard error of a command that ends with ``code``: one line when that is not 0, after warnings of a line each."""
    _, err = running.communicate(timeout=100)
    assert running.returncode == code, err
    assert "Traceback" not in err and "unforeseen" not in err
    assert all(line.startswith("ssao-gl: ") for line in err.splitlines()) and (code == 0 or err), err
    return err


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def whole(folder: Path) -> None:
    """Every output in ``folder`` can be read to its end. Names with a dot are what is at work, or was when it was killed."""
    for path in folder.rglob("*"):
        if any(part.startswith(".") for part in path.relative_to(folder).parts):
            continue
        if path.suffix in (".png", ".npy", ".exr"):
            images.load_image(path)
        elif path.suffix in (".gif", ".webp", ".apng"):
            with Image.open(path) as image:
                for frame in range(getattr(image, "n_frames", 1)):
                    image.seek(frame)
                    image.load()
        elif path.suffix == ".json":
            json.loads(path.read_text())


# The driver


def test_broken_shader_is_named_by_file_and_line(provider: str, tmp_path: Path) -> None:
    folder = shutil.copytree(preprocess.root(), tmp_path / "shaders")
    lines = (folder / "lib" / "view.glsl").read_text().splitlines()
    (folder / "lib" / "view.glsl").write_text("\n".join([*lines, "float broken = ;"]) + "\n")
    target = tmp_path / "a.png"
    running = command("render", "--gl", provider, *SMALL, "-o", target, environment={"SSAO_GL_SHADERS": str(folder)})
    assert f"lib/view.glsl:{len(lines) + 1}" in ended(running, 2)
    assert not target.exists()


BROKEN_FOLDERS: dict[str, tuple[Callable[[Path], object], str]] = {
    "not text": (lambda folder: (folder / "composite.frag").write_bytes(b"\xff\xfe"), "composite.frag is not UTF-8 text"),
    "gone": (lambda folder: (folder / "composite.frag").unlink(), "there is no shader 'composite.frag'"),
    "an include gone": (lambda folder: (folder / "lib" / "view.glsl").unlink(), "cannot include 'lib/view.glsl'"),
    "all gone": (lambda folder: shutil.rmtree(folder), "the shader files are missing"),
}


@pytest.mark.gl
@pytest.mark.parametrize("case", BROKEN_FOLDERS)
def test_broken_shader_folder(case: str, tmp_path: Path) -> None:
    folder = shutil.copytree(preprocess.root(), tmp_path / "shaders")
    spoil, expected = BROKEN_FOLDERS[case]
    spoil(folder)
    running = command("render", *SMALL, "-o", tmp_path / "a.png", environment={"SSAO_GL_SHADERS": str(folder)})
    assert expected in ended(running, 2)
    assert not (tmp_path / "a.png").exists()


NO_MEMORY = """
import resource, sys
from pathlib import Path
import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene
with ao.Renderer(sys.argv[1]) as renderer:
    scene = default_scene()
    before = renderer.render(scene, size=(32, 24)).image.tobytes()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (used + (128 << 20), hard))
    for size in ((4096, 4096), (2048, 2048)):
        try:
            renderer.render(scene, size=size)
        except (ao.ContextError, MemoryError) as error:
            print("refused", error)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    print("same" if renderer.render(scene, size=(32, 24)).image.tobytes() == before else "different")
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux limits the memory of a process so")
def test_without_memory(provider: str) -> None:
    """A frame for which there is no room is refused, and the next one is as before."""
    ran = subprocess.run([sys.executable, "-c", NO_MEMORY, provider], capture_output=True, text=True, timeout=100)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith("refused ") and ran.stdout.endswith("same\n")


def test_lost_context(any_renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver that was reset draws nothing and says so only when it is asked."""
    scene, camera = shapes.corner(), shapes.camera()
    settings = ao.Settings(method=ao.Alchemy(radius=0.5))
    before = any_renderer.render(scene, camera, (16, 12), settings).image
    with monkeypatch.context() as lost:
        lost.setattr(moderngl.Context, "error", property(lambda self: "GL_CONTEXT_LOST"))
        with pytest.raises(ContextError, match="GL_CONTEXT_LOST"):
            any_renderer.render(scene, camera, (16, 12), settings)
        with pytest.raises(ContextError, match="GL_CONTEXT_LOST"):
            any_renderer.render(shapes.corner(), camera, (16, 12), settings)
        with pytest.raises(ContextError, match="GL_CONTEXT_LOST"):
            any_renderer.apply(np.ones((12, 16), np.float32), camera, settings=settings)
    np.testing.assert_array_equal(any_renderer.render(scene, camera, (16, 12), settings).image, before)


def test_what_was_released_says_so(provider: str) -> None:
    renderer = ao.Renderer(provider)
    renderer.release()
    for _ in range(2):
        with pytest.raises(ContextError, match="was released"):
            renderer.render(shapes.corner(), shapes.camera(), (16, 12))
        with pytest.raises(ContextError, match="was released"):
            renderer.apply(np.ones((12, 16), np.float32), shapes.camera())
        renderer.release()


# The disk

OUTPUTS: dict[str, tuple[list[object], set[str]]] = {
    "PNG": (["render", "--size", "320x240", "-o", "a.png"], set()),
    "PNG of 16 bits": (["render", "--size", "320x240", "--aov", "depth", "--bits", 16, "-o", "a.png"], set()),
    "NPY": (["render", "--size", "320x240", "-o", "a.npy"], set()),
    "EXR": (["render", "--size", "320x240", "-o", "a.exr"], set()),
    "folder": (["render", "--size", "320x240", "-o", "out/"], set()),
    "turntable": (["render", "--size", "320x240", "--turntable", 3, "-o", "out/"], set()),
    "GIF": (["render", "--size", "320x240", "--turntable", 3, "-o", "a.gif"], set()),
    "WebP": (["render", "--size", "320x240", "--turntable", 3, "-o", "a.webp"], set()),
    "APNG": (["render", "--size", "320x240", "--turntable", 3, "-o", "a.apng"], set()),
    "report in JSON": (["render", "--size", "8x6", "-o", "a.npy", "--json", "a.json"], {"a.npy"}),
    "applied": (["apply", "--depth", "d.npy", "--yfov-deg", 40, "-o", "a.npy"], set()),
    "difference": (["compare", "one.png", "other.png", "--diff", "a.png"], set()),
    "truth": (["truth", "--size", "64x48", "--spp", 4, "-o", "a.npy"], set()),
}


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with inputs in a folder above."""
    folder = tmp_path / "place"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.gl
@pytest.mark.parametrize("case", OUTPUTS)
def test_full_disk(case: str, place: Path) -> None:
    """The system refuses after 2 KiB of each file: one line, nothing half-written, nothing beside."""
    line, expected = OUTPUTS[case]
    rng = np.random.default_rng(3)
    inputs = place.parent
    np.save(inputs / "d.npy", np.ones((240, 320), np.float32))
    for name in ("one.png", "other.png"):
        Image.fromarray(rng.integers(0, 255, (240, 320, 3), np.uint8)).save(inputs / name)
    given = [inputs / part if str(part) in ("d.npy", "one.png", "other.png") else part for part in line]
    error = ended(command(*given, limit=2048, environment={"XDG_CACHE_HOME": str(inputs)}), 2)
    assert ("cannot write" in error and "File too large" in error) or "disk full" in error, error
    assert set(files(place)) == expected
    whole(place)


# Interruptions


RUNS: dict[str, list[object]] = {
    "file": ["render", *SMALL, "-o", "a.png"],
    "folder": ["render", *SMALL, "--turntable", 20, "-o", "out/"],
    "animation": ["render", *SMALL, "--turntable", 20, "-o", "a.gif"],
    "tiles": ["render", "--size", "128x96", "--tile", 64, "-o", "a.png"],
}


STOPS = [(case, number) for case in RUNS for number in (signal.SIGINT, signal.SIGKILL)] + [("file", signal.SIGTERM)]


@pytest.mark.gl
@pytest.mark.parametrize(("case", "number"), STOPS)
def test_stopped_at_any_moment(case: str, number: int, place: Path) -> None:
    """Whole files or none; after kills at most one hidden file, or the tiles so far; a run then finishes, and nothing stays."""
    for delay in (0.1, 0.5, 0.9, 1.3):
        running = command(*RUNS[case])
        time.sleep(delay)
        running.send_signal(number)
        _, err = running.communicate(timeout=60)
        early = running.returncode and "__main__.py" not in err  # Python itself, before it runs ours
        assert early or running.returncode in (0, -number, 128 + number), (running.returncode, err)
        assert early or "Traceback" not in err
        whole(place)
        hidden = [path.name for path in place.rglob(".*") if path.suffix != ".tiles" and path.name != ".turntable.json"]
        assert len(hidden) <= (1 if number == signal.SIGKILL else 0), hidden
        assert all(name.endswith((".part.png", ".part.gif", ".part.json")) for name in hidden), hidden
    ended(command(*RUNS[case]))
    assert not list(place.rglob(".*"))
    whole(place)
    assert len(files(place)) == (20 if case == "folder" else 1)


def test_two_runs_into_one_folder(place: Path) -> None:
    """The second is told so before it has written anything."""
    (place / "out").mkdir()
    with locked_folder(place / "out"):
        for line in (["--turntable", 2], []):
            assert "another run is writing there now" in ended(command("render", *SMALL, *line, "-o", "out/"), 2)
    assert files(place) == []
    ended(command("render", *SMALL, "--turntable", 2, "-o", "out/"))
    assert len(files(place)) == 2


def test_many_runs_of_one_file(place: Path) -> None:
    """At the same time: each succeeds or is told so, and the file is one of theirs."""
    runs: list[Any] = [command("render", *SMALL, "--turntable", 8, "-o", "a.gif") for _ in range(4)]
    codes = []
    for running in runs:
        _, err = running.communicate(timeout=100)
        codes.append(running.returncode)
        assert running.returncode == 0 or "another run is writing there now" in err, err
    assert 0 in codes and files(place) == ["a.gif"]
    whole(place)
