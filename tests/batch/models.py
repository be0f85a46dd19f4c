"""Little scene files, commands that draw them, and what a folder holds."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from ssao_gl.batch.jobs import ViewJob, jobs_of
from ssao_gl.batch.request import Request

COUNT = 12
ASKED = ["--cameras", f"orbit:{COUNT}", "--size", "64x48", "--aov", "visibility,depth"]
WHOLE = 3 * COUNT
TABLES = ("results.csv", "results.jsonl")
"""Files that tell of times and processes, and differ from run to run."""


def pyramid(path: Path, height: float = 1.0) -> Path:
    """Write a pyramid on a floor, as OBJ."""
    floor = "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\n"
    base = f"v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 {height} 0\n"
    path.write_text(f"{floor}{base}f 3 2 1\nf 4 3 1\nf 6 5 9\nf 7 6 9\nf 8 7 9\nf 5 8 9\n")
    return path


def jobs(*scenes: Path, cameras: str = "orbit:2", **more: object) -> list[ViewJob]:
    request = Request(cameras=cameras, size=(32, 24), aovs="visibility,depth", **more)  # type: ignore[arg-type]
    return jobs_of([(scene, request) for scene in scenes])[0]


def content(folder: Path) -> dict[str, bytes]:
    """Return all files but the tables, by their paths."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name not in TABLES)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def started(scenes: list[Path], output: Path, *more: str) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "ssao_gl", "batch", *map(str, scenes), *ASKED, "-o", str(output), *more]
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(running: subprocess.Popen[str]) -> tuple[int, list[dict[str, object]], str]:
    out, err = running.communicate(timeout=120)
    return running.returncode, [json.loads(line) for line in out.splitlines()], err


def rows(output: Path) -> list[str]:
    return [json.loads(line)["name"] for line in (output / "results.jsonl").read_text().splitlines()]
