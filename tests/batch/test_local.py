"""Batches by processes of this machine, and what ends them. In the end every byte is as it should be."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import ssao_gl as ao

from .models import ASKED, COUNT, WHOLE, content, ended, rows, started

pytestmark = [pytest.mark.gl, pytest.mark.skipif(sys.platform != "linux", reason="signals and limits as Linux has them")]


def test_a_worker_that_is_killed_is_replaced(three_scenes: list[Path], expected: dict[str, bytes], tmp_path: Path) -> None:
    running = started(three_scenes, tmp_path / "out", "--workers", "2", "--progress", "json")
    assert running.stdout is not None
    begin, first = (json.loads(running.stdout.readline()) for _ in range(2))
    assert begin == {"event": "begin", "views": WHOLE, "before": 0} and first["event"] == "view"
    os.kill(int(first["worker"].rpartition(":")[2]), signal.SIGKILL)
    code, events, err = ended(running)
    assert (code, err) == (0, "")
    assert events[-1] == {"event": "end", "drawn": WHOLE, "before": 0, "failed": 0, "seconds": events[-1]["seconds"]}
    assert sorted([first["name"], *(event["name"] for event in events[:-1])]) == sorted(rows(tmp_path / "out"))
    assert len({event["worker"] for event in events[:-1]} - {first["worker"]}) >= 1
    assert content(tmp_path / "out") == expected


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_the_same_command_goes_on(
    number: signal.Signals, three_scenes: list[Path], expected: dict[str, bytes], tmp_path: Path
) -> None:
    running = started(three_scenes, tmp_path / "out", "--workers", "1", "--progress", "json")
    assert running.stdout is not None
    for _ in range(4):
        running.stdout.readline()
    running.send_signal(number)
    code, _, err = ended(running)
    if number == signal.SIGINT:
        assert code == 130 and err.count("\n") == 1 and "goes on" in err
        assert len(rows(tmp_path / "out")) >= 3, "what is drawn is in the table"
    again = ao.batch(three_scenes, tmp_path / "out", cameras=f"orbit:{COUNT}", size=(64, 48), aovs="visibility,depth")
    assert again.before >= 3 and again.before + again.drawn == WHOLE
    assert content(tmp_path / "out") == expected and len(rows(tmp_path / "out")) == WHOLE


def test_a_full_disk_costs_no_more_than_what_does_not_fit(
    three_scenes: list[Path], expected: dict[str, bytes], tmp_path: Path
) -> None:
    """Files may have 10 000 bytes: visibility and depth, of 12 416 bytes, do not fit, all else does."""
    line = [
        sys.executable,
        "-m",
        "ssao_gl",
        "batch",
        str(three_scenes[0]),
        *ASKED,
        "-o",
        str(tmp_path / "out"),
        "--workers",
        "0",
    ]
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))  # noqa: E731
    code = subprocess.run(line, capture_output=True, text=True, preexec_fn=limit)
    assert code.returncode == 1 and f"{COUNT} failed" in code.stdout and "Traceback" not in code.stderr
    assert "cannot write" in code.stderr and not list((tmp_path / "out").rglob("*.npy"))
    results = ao.batch(three_scenes, tmp_path / "out", cameras=f"orbit:{COUNT}", size=(64, 48), aovs="visibility,depth")
    assert results.drawn == WHOLE and content(tmp_path / "out") == expected
