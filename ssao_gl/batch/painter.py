"""Who draws jobs, one after the other, in one process: with one context, and the scene of the job before still at hand."""

from __future__ import annotations

import os
import platform
import sys
import threading
import time
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ContextError, InputWarning, SceneError, SsaoError, one_line
from ..io.locks import HeldError
from ..loaders.load import load_scene
from ..render.picture import Picture
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.screen_bounds import unseen
from .jobs import ViewJob
from .places import Place
from .rows import Row, failure, mark_of, put_mark

PATIENCE = 10.0
"""Seconds to wait for another process that writes the same file: one that a batch which was killed has left at work."""

if sys.platform != "win32":
    import resource


class Painter:
    """Draws jobs to a place. Threads may share one: they take turns. Raises ContextError when there is no OpenGL."""

    def __init__(self, provider: str) -> None:
        self._provider = provider
        self._renderer: Renderer | None = Renderer(provider)
        self._path: Path | None = None
        self._scene: Scene | SceneError | None = None
        self._told: list[str] = []
        self._lock = threading.Lock()

    def draw(self, job: ViewJob, place: Place) -> Row:
        """Draw a job, write its outputs, then its mark, and return its row; of a job that fails, one with ``error``.

        A job that is marked as done meanwhile is not drawn again.
        """
        started = time.perf_counter()
        try:
            with self._lock:
                return mark_of(place, job) or self._drawn(job, place, started)
        except ContextError as error:  # the context may be lost; the next job gets a new one
            self.release()
            return failure(job, one_line(error, 500))
        except MemoryError:
            return failure(job, "out of memory; try a smaller size or a smaller scene")
        except SsaoError as error:
            return failure(job, one_line(error, 500))
        except Exception as error:  # of one job; the others go on
            return failure(job, f"unforeseen {type(error).__name__}: {one_line(error, 200)}")

    def _drawn(self, job: ViewJob, place: Place, started: float) -> Row:
        with _collected() as told:
            scene = self._loaded(job.scene)
            camera = job.view.camera(scene, job.size)
        settings = job.settings if job.share is None else job.settings.with_radius(scene.default_radius(job.share))
        if self._renderer is None:
            self._renderer = Renderer(self._provider)
        picture = self._renderer.render(scene, camera, job.size, settings, aovs=job.aovs)
        outputs = {file: _save(place, file, picture, aov) for aov, files in job.files.items() for file in files}
        told_of = _told_by(picture, camera, job)
        blind = "" if told_of["coverage"] else unseen(scene, camera, job.size)
        row = {
            **told_of,
            "outputs": outputs,
            "warnings": [*dict.fromkeys([*scene.warnings, *self._told, *told, *([blind] if blind else [])])],
            "seconds": round(time.perf_counter() - started, 4),
            "drawing": round(picture.report["seconds"], 4),
            "worker": f"{platform.node()}:{os.getpid()}",
            "peak_mib": _peak(),
        }
        put_mark(place, row)
        return row

    def _loaded(self, path: Path) -> Scene:
        """Return the scene of the job before, or another in its stead. What cannot be read is not tried twice in a row."""
        if self._path != path:
            self._path, self._scene, self._told = path, None, []
            try:
                with _collected() as told:
                    self._scene = load_scene(path)
                self._told = told
            except SceneError as error:
                self._scene = error
        if isinstance(self._scene, Scene):
            return self._scene
        raise self._scene or SceneError(f"{path}: cannot be read")

    def release(self) -> None:
        """Free the context and the scene."""
        renderer, self._renderer, self._path, self._scene = self._renderer, None, None, None
        if renderer is not None:
            renderer.release()


def _save(place: Place, file: str, picture: Picture, aov: str) -> int:
    """Write one file of an AOV; wait for a process that is at the same one, since it soon ends."""
    array = picture.as_png(aov) if file.endswith(".png") else picture.arrays[aov]
    texts = picture.texts if file.endswith(".png") else {}
    given_up = time.monotonic() + PATIENCE
    while True:
        try:
            return place.save(file, array, texts)
        except HeldError:
            if time.monotonic() > given_up:
                raise
            time.sleep(0.05)


def _told_by(picture: Picture, camera: Camera, job: ViewJob) -> Row:
    name = job.name.removeprefix(f"{job.group}/")
    return {
        "name": job.name,
        "group": job.group,
        "index": job.index,
        "identity": job.identity,
        "scene": str(job.scene),
        "camera": (camera if camera.name == name else camera.named(name)).to_json(),
        "size": list(job.size),
        "coverage": _coverage(picture.arrays),
        "method": job.settings.method.name,
        "provider": picture.report.get("provider"),
        "renderer": picture.report.get("renderer"),
        "files": {aov: list(files) for aov, files in job.files.items()},
    }


def _coverage(arrays: Mapping[str, Any]) -> float | None:
    """Return the share of pixels that show something; None when no AOV tells it."""
    if "depth" in arrays:
        return round(float(np.count_nonzero(arrays["depth"]) / arrays["depth"].size), 6)
    if "normal" in arrays:
        return round(float(arrays["normal"].any(2).mean()), 6)
    return None


@contextmanager
def _collected() -> Iterator[list[str]]:
    """Yield a list of the :class:`InputWarning` of the block."""
    told: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        yield told
    told += [one_line(one.message) for one in caught if issubclass(one.category, InputWarning)]


def _peak() -> float | None:
    """Return the most memory that this process has held so far, MiB."""
    if sys.platform == "win32":
        return None
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(most / (1 << 20 if sys.platform == "darwin" else 1 << 10), 1)
