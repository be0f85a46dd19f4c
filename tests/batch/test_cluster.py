"""Batches by a cluster whose workers and scheduler are killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import ssao_gl as ao

from .models import COUNT, WHOLE, content, ended, rows, started

pytestmark = [pytest.mark.gl, pytest.mark.skipif(sys.platform != "linux", reason="signals as Linux has them")]


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes], list[subprocess.Popen[bytes]]]]:
    """A scheduler and two worker processes; ended in the end with all that they started."""
    file = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True, "cwd": folder}
    made: list[subprocess.Popen[bytes]] = []

    def start(module: str, *words: str) -> subprocess.Popen[bytes]:
        line = [sys.executable, "-m", f"distributed.cli.{module}", "--scheduler-file", str(file), "--no-dashboard", *words]
        made.append(subprocess.Popen(line, **quiet))  # type: ignore[call-overload]
        return made[-1]

    try:
        scheduler = start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-show")
        workers = [start("dask_worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
        address = ""
        while not address:
            time.sleep(0.05)
            assert scheduler.poll() is None
            address = json.loads(file.read_text())["address"] if file.exists() and file.stat().st_size else ""
        yield address, scheduler, workers
    finally:
        for process in made:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def test_a_cluster_survives_its_workers_and_is_survived(
    three_scenes: list[Path], expected: dict[str, bytes], tmp_path: Path
) -> None:
    output = tmp_path / "out"
    with cluster(tmp_path) as (address, scheduler, workers):
        running = started(three_scenes, output, "--dask", address, "--progress", "json")
        while len(list(output.rglob("depth.npy"))) < 2 and running.poll() is None:
            time.sleep(0.02)
        workers[0].kill()
        code, events, err = ended(running)
        assert (code, err) == (0, ""), events
        assert content(output) == expected and len(rows(output)) == WHOLE, "by the worker that was left"

        running = started(three_scenes, tmp_path / "cut", "--dask", address, "--progress", "json")
        while len(list((tmp_path / "cut").rglob("depth.npy"))) < 2 and running.poll() is None:
            time.sleep(0.02)
        scheduler.kill()
        code, _, err = ended(running)
        assert code == 2 and "is gone" in err and "goes on" in err and err.count("\n") == 1, err
    results = ao.batch(three_scenes, tmp_path / "cut", cameras=f"orbit:{COUNT}", size=(64, 48), aovs="visibility,depth")
    assert results.before >= 2 and content(tmp_path / "cut") == expected and len(rows(tmp_path / "cut")) == WHOLE


def test_ctrl_c_ends_a_cluster_made_here(three_scenes: list[Path], tmp_path: Path) -> None:
    """A terminal sends it to all processes; each of them would have something to say."""
    asked = ["--dask", "local:1", "--progress", "json", "--size", "320x240"]
    line = [sys.executable, "-m", "ssao_gl", "batch", str(three_scenes[0]), "--cameras", "orbit:300", *asked, "-o", "out"]
    running = subprocess.Popen(
        line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, cwd=tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    assert running.stdout is not None
    for _ in range(9):  # the beginning, and a task
        assert running.stdout.readline()
    os.killpg(running.pid, signal.SIGINT)
    code, _, err = ended(running)
    assert code == 130 and err.count("\n") == 1 and "goes on" in err, err
    assert 8 <= len(rows(tmp_path / "out")) < 300 and not list((tmp_path / "out").rglob(".*"))
