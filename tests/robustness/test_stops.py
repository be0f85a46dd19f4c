"""SIGINT and SIGTERM from the first import to the last frame: the right exit code, one line, and nothing half-written."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = [
    pytest.mark.gl,
    pytest.mark.skipif(sys.platform != "linux", reason="/proc tells when a process imports"),
]

JOBS: dict[str, list[str]] = {
    "folder": ["--size", "160x120", "--turntable", "5000", "-o", "t/"],
    "animation": ["--size", "100x80", "--turntable", "5000", "-o", "t.webp"],
    "tiles": ["--size", "8000x6000", "--tile", "128", "-o", "t.png"],
}
KEPT = {"t", ".t.webp.tiles", ".t.png.tiles"}
"""What the same command goes on from."""
DELAYS = (0.0, 0.1, 0.3, 1.5)
"""Seconds since the imports began: three times within them, and once within drawing."""


def importing(process: subprocess.Popen[str]) -> bool:
    """Return whether a process has begun with its imports: Python itself, before it runs anything of ours, heeds nothing."""
    return "numpy" in Path(f"/proc/{process.pid}/maps").read_text()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("job", JOBS)
def test_a_signal_ends_it_at_any_moment(job: str, number: signal.Signals, tmp_path: Path) -> None:
    for delay in DELAYS:
        place = tmp_path / str(delay)
        place.mkdir()
        running = subprocess.Popen(
            [sys.executable, "-m", "ssao_gl", "render", *JOBS[job]], cwd=place, stdout=subprocess.PIPE, text=True,
            stderr=subprocess.STDOUT, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )  # fmt: skip
        while not importing(running):
            assert running.poll() is None
            time.sleep(0.005)
        time.sleep(delay)
        running.send_signal(number)
        said, _ = running.communicate(timeout=60)
        assert running.returncode == 128 + number, (delay, said)
        assert said.startswith(f"ssao-gl: {'interrupted' if number == signal.SIGINT else 'terminated'}"), (delay, said)
        assert said.count("\n") == 1
        assert {path.name for path in place.iterdir()} <= KEPT
        assert not list(place.rglob("*.part*")), delay


LATE = """
import os, sys
class Late:
    def __del__(self, kill=os.kill, pid=os.getpid(), number=int(sys.argv.pop())):
        kill(pid, number)
late = Late()
from ssao_gl.__main__ import main
main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_after_the_work_changes_nothing(number: signal.Signals) -> None:
    """Python clears its modules at its end, when it has given up its handlers of signals."""
    line = [sys.executable, "-c", LATE, "--version", str(int(number))]
    ended = subprocess.run(
        line, capture_output=True, text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler)
    )
    assert (ended.returncode, ended.stderr) == (0, "") and ended.stdout.strip()
