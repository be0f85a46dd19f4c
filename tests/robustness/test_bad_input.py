"""Broken cameras, arguments, settings and arrays, and interruptions: one clear line, exit code 2, nothing written."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..command_line import refused, run
from ..scene_files import BIG, OBJ


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An empty one."""
    made = tmp_path / "scenes"
    made.mkdir()
    return made


CAMERA: dict[str, Any] = {"name": "front", "eye": [0, 0, 5], "target": [0, 0, 0], "yfov_deg": 40}


def camera_file(**changes: Any) -> str:
    entry = {key: value for key, value in (CAMERA | changes).items() if value is not ...}
    return json.dumps({"cameras": [entry]})


CAMERAS: dict[str, tuple[str, str]] = {
    "empty": ("", "the file is empty"),
    "not JSON": ("{", "not JSON"),
    "a list": ("[]", "expected an object with a list 'cameras'"),
    "no cameras": ('{"cameras": []}', "expected an object with a list 'cameras'"),
    "cameras of text": ('{"cameras": "front"}', "expected an object with a list 'cameras'"),
    "a camera of text": ('{"cameras": ["front"]}', "camera 0 is not an object"),
    "too deep": ("[" * 100000, "not JSON"),
    "eye missing": (camera_file(eye=...), "lacks 'eye'"),
    "eye misspelt": (camera_file(eye=..., eyes=[0, 0, 1]), "lacks 'eye'. Did you mean 'eyes'?"),
    "eye of text": (camera_file(eye="here"), "('front')"),
    "eye of two": (camera_file(eye=[0, 1]), "three finite numbers"),
    "eye of NaN": (camera_file(eye=[0, 0, float("nan")]), "three finite numbers"),
    "eye of an object": (camera_file(eye={"x": 1}), "camera 0"),
    "eye is target": (camera_file(eye=[0, 0, 0]), "same point"),
    "up parallel": (camera_file(up=[0, 0, 1]), "parallel"),
    "up zero": (camera_file(up=[0, 0, 0]), "parallel"),
    "yfov missing": (camera_file(yfov_deg=...), "lacks 'yfov_deg'"),
    "yfov 0": (camera_file(yfov_deg=0), "yfov"),
    "yfov 180": (camera_file(yfov_deg=180), "yfov"),
    "yfov NaN": (camera_file(yfov_deg=float("nan")), "yfov"),
    "yfov of text": (camera_file(yfov_deg="wide"), "'wide'"),
    "yfov huge": (camera_file(yfov_deg=10**400), "camera 0"),
    "znear 0": (camera_file(znear=0), "znear=0 must be above 0"),
    "znear -1": (camera_file(znear=-1), "znear=-1 must be above 0"),
    "zfar before znear": (camera_file(znear=2, zfar=1), "zfar=1 must lie behind znear=2"),
    "zfar NaN": (camera_file(zfar=float("nan")), "zfar"),
    "ortho 0": (camera_file(ortho_height=0), "orthographic height"),
    "radius 0": (camera_file(ao_radius=0), "ao_radius=0"),
    "radius NaN": (camera_file(ao_radius=float("nan")), "ao_radius"),
    "radius infinite": (camera_file(ao_radius=float("inf")), "ao_radius"),
    "radius of a list": (camera_file(ao_radius=[1]), "camera 0"),
}


@pytest.mark.parametrize("case", CAMERAS)
def test_broken_camera_file(case: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, expected = CAMERAS[case]
    path = folder / "a.cam.json"
    path.write_text(text)
    line = refused(capsys, "explain", "--camera", path)
    assert str(path) in line and expected in line


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("a.cam.json:frnt", "Did you mean 'front'?"),
        ("a.cam.json:7", "a number from 0 to 0"),
        ("a.cam.json:-1", "no camera '-1'"),
        ("a.cam.json:²", "no camera '²'"),
        ("gone.cam.json", "no such file"),
        ("gone.cam.json:front", "no such file"),
        (".", "is a folder"),
        ("/dev/zero", "not a regular file"),
    ],
)
def test_wrong_camera(spec: str, expected: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.cam.json").write_text(camera_file())
    assert expected in refused(capsys, "explain", "--camera", spec if spec[0] == "/" else f"{folder}/{spec}")


ARGUMENTS: dict[str, str] = {
    "rendr": "Did you mean 'render'?",
    "render --size 0x0": "sides from 1",
    "render --size 99999x99999": "sides from 1 to 65536",
    "render --size -5x3": "WIDTHxHEIGHT",
    "render --size 10": "WIDTHxHEIGHT",
    "render --size 1e3x5": "WIDTHxHEIGHT",
    "render --size ٣x٣": "WIDTHxHEIGHT",
    "render --size 4x": "WIDTHxHEIGHT",
    "render --size 123456789012345678901234567890x5": "sides from 1",
    "render --bogus": "unknown option --bogus",
    "render --siz 4x4": "Did you mean '--size'?",
    "render --samples": "--samples needs a value: Taps a pixel",
    "render --samples many": "--samples many: must be a whole number",
    "render --method alchemy --samples 0": "alchemy.samples=0: must be 1 to",
    "render --method alchemy --samples -4": "alchemy.samples=-4: must be 1 to",
    f"render --method alchemy --samples {10**400}": "must be a finite whole number",
    "render --radius nan": "bitmask.radius=nan: must be a finite number",
    "render --radius inf": "must be a finite number",
    "render --radius -1": "must be above 0 (scene units)",
    "render --radius wide": "a number of scene units, or a share",
    "render --method alchmy": "Did you mean 'alchemy'?",
    "render --blur joit": "Did you mean 'joint'?",
    "render --set foo": "must be key=value",
    "render --set foo=1": "bitmask has no setting 'foo'",
    "render --set radus=1": "Did you mean 'radius'?",
    "render --set lecture.radius=1": "add --method lecture",
    "render --set joint.radius=1": "unknown group of settings 'joint'",
    "render --set blur.radius=99": "must be 1 to 16 (pixels)",
    "render --set steps=2.5": "must be a whole number",
    "render --set shading.background=red": "must look like #rrggbb",
    "render --blur none --set blur.radius=1": "blur is 'none'",
    "render --aov visiblity": "Did you mean 'visibility'?",
    "render --aov ,": "name at least one",
    "render --aov depth,normal -o a.png": "one file holds one AOV",
    "render --bits 12": "must be 8 or 16",
    "render --gl egl": "unknown provider of OpenGL 'egl'; there are auto, egl-es",
    "render --turntable -1": "must be 1 to",
    "render --turntable 3 -o a.png": "a turntable goes to a folder",
    "render --turntable 3 -o tt --json a.json": "leave it out",
    "render --eye 1,2": "must be three numbers",
    "render --eye 1,2,3,4": "must be three numbers",
    "render --eye 1,nan,3": "three finite numbers",
    "render --eye=": "must be three numbers",
    "render --eye 1,1,1 --target 1,1,1": "same point",
    "render --eye 0,5,0 --target 0,0,0 --up 0,1,0": "parallel",
    "render --yfov-deg 0": "between 0 and 180",
    "render --yfov-deg 180": "between 0 and 180",
    "render --yfov-deg nan": "between 0 and 180",
    "render --znear 0": "znear=0 must be above 0",
    "render --znear 5 --zfar 1": "must lie behind",
    "render --zfar nan": "must lie behind",
    "render --ortho 0": "orthographic height",
    "render --ortho nan": "orthographic height",
    "render --ortho 3 --yfov-deg 3": "exclude each other",
    "render --config gone.toml": "no such file",
    "render --config /dev/zero": "not a regular file",
    "render -o a.jpg": "unknown suffix '.jpg'",
    "render -o a.pngg": "Did you mean '.png'?",
    "render -o gone/a.png": "no folder gone",
    "render -o here.txt/x/": "here.txt is not a folder",
    "render -o here.txt/a.png": "here.txt is not a folder",
    "render -o file": "is a file",
    "render -o /proc/a.png": "cannot write /proc/a.png",
    "render -o /proc/a/": "cannot write /proc/a",
    "render --json gone/a.json": "no folder gone",
    "render --json --size 4x4": "must be a file name",
    "explain --aov foo": "unknown AOV",
    "explain --crease-deg 200 here.obj": "must be 0 to 180",
    "explain --up-axis w here.obj": "must be x, y, z or auto",
    "methods alchem": "Did you mean 'alchemy'?",
    "shader alchem": "there is no shader 'alchem'",
    "shader ../../pyproject.toml": "there is no shader",
    "shader alchemy --dialect es30": "Did you mean 'es300'?",
    "shader alchemy --define 3=4": "must be NAME or NAME=VALUE",
    "compare gone.png gone.png": "no such file",
    "compare small.npy large.npy": "shape",
    "compare small.npy small.npy --metric rmsee": "Did you mean 'rmse'?",
    "compare small.npy small.npy --max-abs nan": "must be at least 0",
    "compare small.npy small.npy --max-abs -1": "must be at least 0",
    "compare small.npy small.npy --diff a.jpg": "unknown suffix '.jpg'",
    "compare small.npy here.txt": "not a readable picture",
    "apply --depth small.npy": "say how the depth was seen",
    "apply --depth small.npy --yfov-deg 40 --ortho 2": "say how the depth was seen",
    "apply --depth small.npy --intrinsics 1,2,3": "fx,fy,cx,cy",
    "apply --depth small.npy --intrinsics 1,0,3,4": "above 0",
    "apply --depth small.npy --yfov-deg 40 --strength 2": "must be 0 to 1",
    "apply --depth small.npy --yfov-deg 40 -o a.jpg": "unknown suffix",
    "apply --yfov-deg 40": "--depth",
    "apply --depth gone.npy --yfov-deg 40": "no such file",
    "apply --depth objects.npy --yfov-deg 40": "not a readable picture or array",
    "apply --depth complex.npy --yfov-deg 40": "holds complex128",
    "apply --depth text.npy --yfov-deg 40": "expected numbers",
    "apply --depth none.npy --yfov-deg 40": "",
    "apply --depth flat.npy --yfov-deg 40": "shape (12,)",
    "apply --depth huge.npy --yfov-deg 40": "not a readable picture or array",
    "apply --depth pack.npy --yfov-deg 40": "NPZ",
    "apply --depth small.png --yfov-deg 40": "depth must be floats",
}


@pytest.fixture
def place(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with some files in it; nothing may be added or changed."""
    from PIL import Image

    monkeypatch.chdir(folder)
    np.save("small.npy", np.ones((3, 4), np.float32))
    np.save("large.npy", np.ones((5, 4), np.float32))
    np.save("objects.npy", np.array([[{}]], object), allow_pickle=True)
    np.save("complex.npy", np.ones((3, 4), complex))
    np.save("text.npy", np.array([["a", "b"]]))
    np.save("none.npy", np.ones((0, 4), np.float32))
    np.save("flat.npy", np.ones(12, np.float32))
    with Path("huge.npy").open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (BIG, 4)})
    with Path("pack.npy").open("wb") as file:
        np.savez(file, a=np.ones(3))
    Image.fromarray(np.zeros((3, 4), np.uint8)).save("small.png")
    Path("here.txt").write_text("hello")
    Path("file").write_text("hello")
    Path("here.obj").write_text(OBJ)
    before = sorted(folder.rglob("*"))
    yield folder
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("line", ARGUMENTS, ids=lambda line: line[:60])
def test_bad_arguments(line: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ARGUMENTS[line] in refused(capsys, *line.split())


TOML: dict[str, str] = {
    "radius = ": "not TOML",
    "a" + "[" * 5000: "not TOML",
    "radius = 1": "groups are tables, like [bitmask]",
    "method = 3": "must be a name in quotes",
    "method = 'alchmy'": "Did you mean 'alchemy'?",
    "[alchmy]\nradius = 1": "Did you mean 'alchemy'?",
    "[bitmask]\nradus = 1": "Did you mean 'radius'?",
    "[bitmask]\nradius = 'a'": "must be a number",
    "[bitmask]\nradius = true": "must be a finite number",
    "[bitmask]\nradius = []": "must be a finite number",
    "[bitmask]\nradius = nan": "must be a finite number",
    "[bitmask]\nradius = 1979-05-27": "must be a finite number",
    "[bitmask.radius]\nx = 1": "must be a finite number",
    "[bitmask]\nsteps = 1.5": "must be a finite whole number",
    "[shading]\nbackground = 7": "must be text",
    "blur = 'none'\n[blur_joint]\nradius = 99": "",
}


@pytest.mark.parametrize("text", TOML)
def test_bad_settings_file(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "a.toml"
    path.write_text(text)
    if TOML[text]:
        assert TOML[text] in refused(capsys, "explain", "--config", path)
    else:
        assert run("explain", "--config", path, capsys=capsys)[0] == 0


def test_settings_file_of_bytes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.toml").write_bytes(b"\xff\xfe\x00")
    assert "not TOML" in refused(capsys, "explain", "--config", folder / "a.toml")
    (folder / "a.toml").write_bytes(b"")
    assert run("explain", "--config", folder / "a.toml", capsys=capsys)[0] == 0


@pytest.mark.gl
def test_arrays_that_do_not_fit(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from PIL import Image

    monkeypatch.chdir(folder)
    np.save("d.npy", np.ones((3, 4), np.float32))
    np.save("n.npy", np.ones((3, 4), np.float32))
    Image.fromarray(np.zeros((5, 5, 3), np.uint8)).save("c.png")
    view = ("--depth", "d.npy", "--yfov-deg", "40", "-o", "out.png")
    assert "color is 5x5, depth 4x3; expected the same size, or larger" in refused(capsys, "apply", "c.png", *view)
    assert "normals are float32 of shape (3, 4)" in refused(capsys, "apply", *view, "--normals", "n.npy")
    assert "no usable texel" in refused(capsys, "apply", *view, "--depth-kind", "window")  # all at the far plane
    assert "depth kind 'eyes'" in refused(capsys, "apply", *view, "--depth-kind", "eyes", "--radius", "1")
    assert not Path("out.png").exists()


def test_no_opengl(capsys: pytest.CaptureFixture[str], folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every provider fails: exit code 3, with the reasons and the cures."""
    import dataclasses

    from ssao_gl.gl import providers

    def fail() -> Any:
        raise OSError("there is none")

    broken = {name: dataclasses.replace(each, open=fail) for name, each in providers.PROVIDERS.items()}
    monkeypatch.setattr(providers, "PROVIDERS", broken)
    code, _, err = run("render", "-o", folder / "a.png", "--size", "8x8", capsys=capsys)
    assert code == 3 and err.startswith("ssao-gl: no OpenGL could be opened") and "Try: " in err
    assert "Traceback" not in err and not list(folder.iterdir())


@pytest.mark.gl
def test_full_disk(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """An error while the file is written leaves neither it nor a temporary one, and an older one stays."""
    import errno

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    target = folder / "a.npy"
    target.write_bytes(b"older")
    monkeypatch.setattr(np, "save", full)
    line = refused(capsys, "render", "-o", target, "--size", "8x8")
    assert f"cannot write {target}: No space left on device" in line
    assert list(folder.iterdir()) == [target] and target.read_bytes() == b"older"


@pytest.mark.gl
@pytest.mark.parametrize("name", ["a.png", "a.npy", "a.exr", "turn.gif"])
def test_file_too_large(name: str, folder: Path) -> None:
    """As on a full disk, but for real: the system refuses after 2 KiB."""
    script = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048)); from ssao_gl.cli import main; main(sys.argv[1:])"
    options = ["--turntable", "2"] if name == "turn.gif" else []
    line = [sys.executable, "-c", script, "render", "--size", "320x240", "-o", str(folder / name), *options]
    ran = subprocess.run(line, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 2 and ran.stderr.startswith(f"ssao-gl: cannot write {folder / name}: "), ran.stderr
    assert ran.stderr.count("\n") == 1 and not list(folder.iterdir())


def test_verbose_shows_the_trace(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    code, _, err = run("-v", "explain", folder / "gone.glb", capsys=capsys)
    assert code == 2 and "Traceback" in err and "ssao-gl: " in err.splitlines()[-1]


def test_unforeseen_errors_are_one_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from ssao_gl.cli import explain

    def fail(*_: object, **__: object) -> Any:
        raise KeyError("x")

    monkeypatch.setattr(explain, "plan_render", fail)
    code, _, err = run("explain", capsys=capsys)
    assert code == 2 and "unforeseen KeyError" in err and err.count("\n") == 1


def test_terminal_codes_are_not_passed_on(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    assert "\x1b" not in refused(capsys, "explain", folder / "\x1b[31mred.glb")


def command(*arguments: object, **options: Any) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "ssao_gl", *map(str, arguments)]
    # Tests that run in the background inherit an ignored Ctrl-C; a user's shell does not hand that on.
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_ctrl_c, **options)


def heed_ctrl_c() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.gl
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("output", ["frames", "a.gif"])
def test_interrupted(number: int, code: int, output: str, folder: Path) -> None:
    """A turntable is stopped: whole files or none, and what the same command goes on from."""
    running = command("render", "--turntable", 2000, "--size", "64x48", "-o", folder / output)
    started = time.perf_counter()
    while output == "frames" and not list(folder.glob("frames/*.png")) and time.perf_counter() - started < 30:
        time.sleep(0.05)
    time.sleep(1.5 if output != "frames" else 0)
    running.send_signal(number)
    _, err = running.communicate(timeout=30)
    assert running.returncode == code, err
    assert "Traceback" not in err
    from PIL import Image

    kept = {folder / "frames" / ".turntable.json", folder / ".a.gif.tiles", *folder.glob(".a.gif.tiles/*")}
    for path in set(folder.rglob("*.*")) - kept:
        assert not path.name.startswith(".")
        Image.open(path).load()
    assert err.count("\n") == 1 and (not kept & set(folder.rglob("*")) or "the same command goes on from there" in err)


@pytest.mark.gl
@pytest.mark.parametrize("arguments", [("methods",), ("shader", "alchemy"), ("explain",)])
def test_closed_pipe(arguments: tuple[str, ...]) -> None:
    with command(*arguments) as running:
        assert running.stdout is not None and running.stderr is not None
        running.stdout.close()
        err = running.stderr.read()
        assert running.wait(30) == 0 and err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_full_standard_output() -> None:
    with Path("/dev/full").open("w") as full:
        ran = subprocess.run([sys.executable, "-m", "ssao_gl", "methods"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert ran.returncode == 2 and ran.stderr == "ssao-gl: standard output: No space left on device\n"


def test_locale_without_unicode() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "NO_COLOR": "1"}
    ran = subprocess.run([sys.executable, "-m", "ssao_gl", "methods"], env=environment, capture_output=True)
    assert ran.returncode == 0 and ran.stdout.isascii() and b"\x1b" not in ran.stdout
