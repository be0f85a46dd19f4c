"""Tries broken scene files in a process of its own, which may be killed: ``python -m tests.robustness.fuzz_worker``; see fuzz_loaders."""

from __future__ import annotations

import json
import logging
import os
import re
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import ssao_gl as ao
from ssao_gl.errors import SsaoError

from .fuzz_mutations import mutant
from .fuzz_seeds import Files, seeds

SECONDS, MEMORY = 10.0, 2 << 30
STARTED = ("socket.connect", "socket.getaddrinfo", "urllib.Request", "subprocess.Popen", "os.system", "os.exec", "os.fork")
LIBRARIES = (
    sys.prefix,
    sys.base_prefix,
    str(Path(ao.__file__).parents[1]),
    *sys.path[1:],
    "/usr",
    "/lib",
    "/proc",
    "/sys",
    "/dev",
)


def case(index: int, seed: int, made: dict[str, Files]) -> tuple[str, Files]:
    """The name of the seed and the files of mutant ``index``."""
    rng = np.random.default_rng([seed, index])
    name = list(made)[rng.integers(len(made))]
    return name, mutant(made[name], rng)


def write(folder: Path, files: Files) -> Path:
    """The files, and nothing else, in ``folder``; the first is the scene's."""
    folder.mkdir(exist_ok=True, parents=True)
    for path in folder.iterdir():
        path.unlink()
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder / next(iter(files))


class Watch(logging.Handler):
    """What a load does that it must not do, from Python's audit events and the package's log."""

    def __init__(self) -> None:
        super().__init__()
        self.folder: Path | None = None
        self.seen: list[str] = []
        logging.getLogger("ssao_gl").addHandler(self)
        sys.addaudithook(self._event)

    def emit(self, record: logging.LogRecord) -> None:
        self.check_line("warning", record.getMessage())

    def check_line(self, what: str, text: str) -> None:
        """A message is one line that can be printed, of a sane length."""
        if not text.isprintable() or len(text) > 1000:
            self.seen.append(f"{what} is not one line: {text[:200]!r}")

    def _event(self, name: str, arguments: tuple[Any, ...]) -> None:
        if self.folder is None:
            return
        if name in STARTED:
            self.seen.append(f"{name} {arguments!r:.200}")
        elif name == "open" and isinstance(arguments[0], str | bytes):
            path = os.path.realpath(os.fsdecode(arguments[0]))
            if not path.startswith((str(self.folder), *LIBRARIES)):
                self.seen.append(f"opened {path}")


def trial(path: Path, watch: Watch, renderer: ao.Renderer | None = None) -> tuple[str, str]:
    """(verdict, detail) of loading, and drawing, one file: ``scene``, ``refused`` or ``violation``."""
    watch.seen.clear()
    watch.folder = path.parent
    try:
        scene = ao.load_scene(path)
        verdict, detail = "scene", f"{scene.triangles} triangles"
        if renderer is not None:
            _draw(scene, renderer)
    except SsaoError as error:
        verdict, detail = "refused", str(error)
        watch.check_line("error", detail)
        if not detail.startswith(str(path)) or "MemoryError" in detail or "out of memory" in detail.lower():
            return "violation", detail
    except BaseException as error:
        return "violation", f"{type(error).__name__}: {error}"
    finally:
        watch.folder = None
    return ("violation", "; ".join(watch.seen)) if watch.seen else (verdict, detail)


def _draw(scene: ao.Scene, renderer: ao.Renderer) -> None:
    if not np.isfinite(scene.bounds).all():
        raise ValueError(f"bounds {scene.bounds.tolist()}")
    v = renderer.render(scene, size=(24, 16), aovs=("visibility", "image"), checked=True).visibility
    if not (np.isfinite(v).all() and v.min() >= 0 and v.max() <= 1):
        raise ValueError(f"visibility from {v.min()} to {v.max()}")


def limit_memory(more: int = MEMORY) -> None:
    """From here on this process may take so many bytes more, and no others."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + more, used + more))


def main(first: int, last: int, seed: int, draw: bool, only: str, scenes: list[Path]) -> None:
    """Files first..last-1: a line of JSON for each, after an empty one."""
    made = seeds(scenes, only)
    renderer = ao.Renderer() if draw else None
    watch = Watch()
    with tempfile.TemporaryDirectory() as top:
        folder = Path(top).resolve() / "scene"
        for whole in made.values():  # imports, and what drivers set aside, are not the broken files' fault
            trial(write(folder, whole), watch, renderer)
        limit_memory()
        print(flush=True)
        for index in range(first, last):
            name, files = case(index, seed, made)
            path = write(folder, files)
            began = time.process_time()
            verdict, detail = trial(path, watch, renderer)
            spent = time.process_time() - began
            if spent > SECONDS:
                verdict, detail = "violation", f"took {spent:.1f} s; {detail}"
            peak = int(re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())[1]) << 10  # type: ignore[index]
            found = {"index": index, "seed": name, "verdict": verdict, "detail": detail, "seconds": spent, "peak": peak}
            print(json.dumps(found), flush=True)


if __name__ == "__main__":
    _, first, last, seed, how, only, *scenes = sys.argv
    main(int(first), int(last), int(seed), how == "draw", only, [Path(name) for name in scenes])
