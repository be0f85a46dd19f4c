"""Outputs that are no regular files: links, pipes, devices and standard output, by the command line as it is run."""

from __future__ import annotations

import io
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="devices and pipes of POSIX")

OPTIONS: dict[str, list[str]] = {
    "-o": ["render", "--size", "16x12", "-o", "PLACE"],
    "--json": ["render", "--size", "16x12", "-o", "a.npy", "--json", "PLACE"],
    "--diff": ["compare", "one.png", "other.png", "--diff", "PLACE"],
    "page": ["stress", "--only", "plane", "--methods", "alchemy", "-o", "PLACE"],
}
SUFFIXES = {"--json": ".json", "page": ".html"}
STARTS = {"--json": b"{", "page": b"<!doctype html>"}
KINDS = ("device", "full device", "pipe", "link")


def command(folder: Path, *arguments: str, **options: Any) -> subprocess.Popen[bytes]:
    line = [sys.executable, "-m", "ssao_gl", *arguments]
    return subprocess.Popen(line, cwd=folder, stderr=subprocess.PIPE, **{"stdout": subprocess.PIPE, **options})


def device(path: Path, minor: int) -> None:
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, minor))
        path.open("wb").close()
    except PermissionError:
        pytest.skip("devices cannot be made here")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, value in (("one.png", 0), ("other.png", 9)):
        Image.fromarray(np.full((12, 16, 3), value, np.uint8)).save(tmp_path / name)
    return tmp_path


def read(pipe: Path, into: list[bytes]) -> threading.Thread:
    thread = threading.Thread(target=lambda: into.append(pipe.read_bytes()), daemon=True)
    thread.start()
    return thread


@pytest.mark.gl
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_file_stays_what_it_is(kind: str, option: str, folder: Path) -> None:
    place = folder / f"out{SUFFIXES.get(option, '.png')}"
    got: list[bytes] = []
    if kind == "pipe":
        os.mkfifo(place)
        reader = read(place, got)
    elif kind == "link":
        (folder / "far").mkdir()
        place.symlink_to(f"far/{place.name}")
    else:
        device(place, 7 if kind == "full device" else 3)
    before, others = place.lstat(), set(folder.iterdir()) | {folder / "a.npy"}
    running = command(folder, *(place.name if part == "PLACE" else part for part in OPTIONS[option]))
    _, err = running.communicate(timeout=60)
    assert (place.lstat().st_ino, place.lstat().st_mode) == (before.st_ino, before.st_mode)
    assert set(folder.iterdir()) <= others, "nothing is left beside it"
    if kind == "full device":
        assert running.returncode == 2 and err == f"ssao-gl: cannot write {place.name}: No space left on device\n".encode()
        return
    assert running.returncode == 0 and err == b""
    if kind == "pipe":
        reader.join(10)
    if kind != "device":
        data = got[0] if kind == "pipe" else (folder / "far" / place.name).read_bytes()
        assert data.startswith(STARTS.get(option, b"\x89PNG")) and len(data) > 100


@pytest.mark.gl
def test_standard_output_gets_the_picture_and_nothing_else(folder: Path) -> None:
    command(folder, "render", "--size", "16x12", "-o", "a.png").communicate(timeout=60)
    running = command(folder, "render", "--size", "16x12", "-o", "-")
    out, err = running.communicate(timeout=60)
    assert running.returncode == 0 and out == (folder / "a.png").read_bytes()
    assert Image.open(io.BytesIO(out)).size == (16, 12) and err.startswith(b"-: embedded scene") and err.count(b"\n") == 1
    with Path("/dev/full").open("wb") as full:
        running = command(folder, "render", "--size", "16x12", "-o", "-", stdout=full)
        _, err = running.communicate(timeout=60)
    assert running.returncode == 2 and err == b"ssao-gl: cannot write -: No space left on device\n"
    assert {path.name for path in folder.iterdir()} == {"a.png", "one.png", "other.png"}


def test_two_outputs_cannot_share_standard_output(folder: Path) -> None:
    running = command(folder, "render", "-o", "-", "--json", "-")
    out, err = running.communicate(timeout=60)
    assert running.returncode == 2 and out == b"" and err.startswith(b"ssao-gl: -o and --json: only one of them")


@pytest.mark.gl
def test_names_that_are_not_text(folder: Path) -> None:
    """A name of bytes that are no UTF-8, and half a pair in a camera's."""
    odd = os.fsdecode(b"odd-\xff.off")
    (folder / odd).write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    (folder / "c.cam.json").write_text(
        '{"cameras": [{"name": "\\ud800", "eye": [0, 0, 3], "target": [0, 0, 0], "yfov_deg": 40}]}'
    )
    line = ["render", odd, "--camera", "c.cam.json", "--size", "16x12", "-o", os.fsdecode(b"\xfe.png"), "--json", "a.json"]
    running = command(folder, *line)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 0 and err == b"", err
    with Image.open(os.fsdecode(os.fsencode(folder / os.fsdecode(b"\xfe.png")))) as picture:
        assert "ud800" in picture.info["ssao_gl:camera"]


def test_noise_of_libraries_stays_off(folder: Path) -> None:
    OpenEXR = pytest.importorskip("OpenEXR")
    path = folder / "d.exr"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"Y": np.random.default_rng(1).random((64, 64), np.float32)}) as file:
        file.write(str(path))
    os.truncate(path, path.stat().st_size // 2)
    running = command(folder, "apply", "--depth", "d.exr", "--yfov-deg", "40")
    out, err = running.communicate(timeout=60)
    assert running.returncode == 2 and out == b"" and err.startswith(b"ssao-gl: d.exr: ") and err.count(b"\n") == 1


def test_long_values_are_cut(folder: Path) -> None:
    (folder / "a.toml").write_text(f"[bitmask]\nslices = {'9' * 4000}\n")
    running = command(folder, "explain", "--config", "a.toml")
    _, err = running.communicate(timeout=60)
    assert running.returncode == 2 and b"slices=999" in err and b"..." in err and len(err) < 800


@pytest.mark.gl
def test_a_report_follows_links_and_keeps_devices(folder: Path) -> None:
    place = folder / "report"
    place.mkdir()
    (place / "report.html").symlink_to("../page.html")
    device(place / "report.md", 3)
    line = ["report", "--size", "16x12", "--methods", "alchemy", "--presets", "draft", "--spp", "16", "--rounds", "1"]
    running = command(folder, *line, "--no-reference", "--cache", "cache", "-o", "report")
    _, err = running.communicate(timeout=120)
    assert running.returncode == 0, err
    assert (folder / "page.html").read_bytes().startswith(b"<!doctype html>") and (place / "report.html").is_symlink()
    assert stat.S_ISCHR((place / "report.md").lstat().st_mode)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="a folder is needed that nobody can write to")
@pytest.mark.parametrize("option", OPTIONS)
def test_a_folder_that_cannot_be_written_is_named(option: str, folder: Path) -> None:
    """It is said before anything is drawn."""
    place = f"/proc/out{SUFFIXES.get(option, '.png')}"
    before = set(folder.iterdir())
    running = command(folder, *(place if part == "PLACE" else part for part in OPTIONS[option]))
    out, err = running.communicate(timeout=60)
    assert running.returncode == 2 and out == b"" and err.startswith(f"ssao-gl: cannot write {place}: ".encode())
    assert err.count(b"\n") == 1 and b"(in the folder /proc)" in err and set(folder.iterdir()) == before


@pytest.mark.gl
@pytest.mark.parametrize("kind", ["one place", "no area"])
def test_what_cannot_be_seen_is_said(kind: str, folder: Path) -> None:
    """A mesh with all vertices at one place, and one of which every triangle is a line: one clear line on standard error."""
    rows = ["1 2 3"] * 4 if kind == "one place" else ["0 0 0", "1 1 1", "2 2 2", "4 4 4"]
    (folder / "a.off").write_text("\n".join(["OFF", "4 2 0", *rows, "3 0 1 2", "3 1 2 3"]) + "\n")
    running = command(folder, "render", "a.off", "--size", "16x12", "-o", "a.png")
    out, err = running.communicate(timeout=60)
    assert running.returncode == 0 and out.startswith(b"a.png: a.off, 2 triangles") and out.count(b"\n") == 1
    assert err == b"ssao-gl: a.off: nothing can be seen: none of its triangles has an area\n"
