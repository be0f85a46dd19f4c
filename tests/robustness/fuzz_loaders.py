"""Broken scene files by the thousand: each must give a scene or one clear line, in bounded time and memory.

``python -m tests.robustness.fuzz_loaders --files 20000 --seed 1 [--draw] [--keep FOLDER] [SCENE ...]``

Files are made from small seeds of every format, and from the scenes that are given, by seed and number alone:
``--first N --files 1`` makes file N again. Each is loaded in a process that is watched: more than 10 s or 2 GiB, a crash, a
traceback, a message of several lines, a connection, a started program, or an open file outside the scene's folder is a
violation. Exits with 1 when there is one; ``--keep`` saves the files that led to it.
"""

from __future__ import annotations

import argparse
import collections
import json
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .fuzz_seeds import seeds
from .fuzz_worker import SECONDS, case, write


def results(first: int, last: int, seed: int, *, draw: bool, only: str = "", scenes: list[Path]) -> Iterator[dict[str, Any]]:
    """A verdict for each of the files first..last-1, in order; a worker that dies or hangs is replaced."""
    while first < last:
        line = [
            sys.executable,
            "-m",
            "tests.robustness.fuzz_worker",
            str(first),
            str(last),
            str(seed),
            "draw" if draw else "load",
            only,
        ]
        line += [str(path.resolve()) for path in scenes]
        with (
            tempfile.TemporaryFile("w+") as errors,
            subprocess.Popen(line, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=Path(__file__).parents[2]) as worker,
        ):
            for found in _answers(worker, first, last):
                first = found["index"] + 1
                yield found
            errors.seek(0)
            shown = errors.read()
            if "Traceback" in shown:
                yield {
                    "index": first - 1,
                    "seed": "",
                    "verdict": "violation",
                    "seconds": 0.0,
                    "peak": 0,
                    "detail": shown[-500:],
                }


def _answers(worker: subprocess.Popen[str], first: int, last: int) -> Iterator[dict[str, Any]]:
    """What one worker says, and a violation when it stops before its end."""
    assert worker.stdout is not None
    for index in range(first - 1, last):  # it greets once it is ready
        # Of the clock, on a machine with other work; the worker measures its own time.
        hangs = not select.select([worker.stdout], [], [], 6 * SECONDS)[0]
        text = "" if hangs else worker.stdout.readline()
        if not text:
            worker.kill()
            why = f"hangs for {6 * SECONDS:.0f} s" if hangs else f"the process ended with {worker.wait()}"
            yield {"index": max(index, first), "seed": "", "verdict": "violation", "seconds": 0.0, "peak": 0, "detail": why}
            return
        if index >= first:
            yield json.loads(text)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--draw", action="store_true", help="draw what can be loaded, too")
    parser.add_argument("--keep", type=Path, help="folder for the files of violations")
    parser.add_argument("--only", default="", help="names of seeds, by commas")
    parser.add_argument("scenes", nargs="*", type=Path)
    o = parser.parse_args()
    began, counts, times, peak = time.perf_counter(), collections.Counter[str](), [0.0], 0
    for found in results(o.first, o.first + o.files, o.seed, draw=o.draw, only=o.only, scenes=o.scenes):
        counts[found["verdict"]] += 1
        times.append(found["seconds"])
        peak = max(peak, found["peak"])
        if found["verdict"] == "violation":
            name, files = case(found["index"], o.seed, seeds(o.scenes, o.only))
            print(f"{found['index']} ({name}): {found['detail']}", flush=True)
            if o.keep:
                write(o.keep / str(found["index"]), files)
    shown = ", ".join(f"{number} {verdict}" for verdict, number in sorted(counts.items()))
    seconds = time.perf_counter() - began
    print(f"{sum(counts.values())} files in {seconds:.0f} s: {shown}; slowest {max(times):.2f} s CPU, peak {peak >> 20} MiB")
    return 1 if counts["violation"] else 0


if __name__ == "__main__":
    sys.exit(main())
