"""A turn about a scene, drawn frame by frame; what was drawn survives an interruption."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError
from ..io.atomic import atomic_write, followed, locked_folder
from ..pipeline.settings import Settings
from ..render.history import History
from ..render.picture import Picture, save_frames
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from .canvas import TileCanvas, new_folder, read_state
from .identity import picture_identity
from .layout import PixelRect

ANIMATIONS = (".gif", ".webp", ".apng")
STATE = ".turntable.json"
"""Beside the frames in a folder until all are there: how many are, and of which turn."""

HISTORY = ".history_"

Indices = Callable[[range], Iterable[int]]
"""What shows progress: gives the numbers of the frames on."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Turntable:
    """What is drawn from ``count`` sides, and where it goes: an animation of the first AOV, or a folder with a PNG file each.

    In the folder each frame is a folder when there are several AOVs.
    """

    scene: Scene
    camera: Camera
    size: Size
    settings: Settings
    aovs: tuple[str, ...]
    count: int
    output: Path
    flight: tuple[Camera, ...] | None = None
    """Cameras of the frames; None: a turn."""
    averaged: bool = False
    """Whether visibility is averaged over frames."""

    @property
    def animated(self) -> bool:
        """Whether the output is one file."""
        return self.output.suffix.lower() in ANIMATIONS

    @property
    def kept(self) -> Path:
        """What is there only while frames are missing: the frames of an animation so far, or the note in the folder."""
        place = followed(self.output)
        return place.with_name(f".{place.name}.tiles") if self.animated else self.output / STATE

    def identity(self, renderer: Renderer) -> str:
        """Return the hash of everything that decides the pixels."""
        facts: list[Any] = ["turntable", self.aovs, self.count, self.averaged]
        for camera in self.flight or ():
            facts += [camera.pose.tolist(), camera.lens.matrix(self.size).tolist()]
        return picture_identity(renderer, self.scene, self.camera, self.size, self.settings, facts)

    def before(self, index: int) -> Path:
        """Return what is there only while frames are missing, too: what the frames before one left for it."""
        return (self.kept if self.animated else self.output) / f"{HISTORY}{index}.npz"

    def frame(self, index: int) -> Path:
        """Return where a frame goes in the folder."""
        return self.output / (f"{index:04d}.png" if len(self.aovs) == 1 else f"{index:04d}")


def draw_turntable(renderer: Renderer, job: Turntable, track: Indices = iter) -> int:
    """Draw the frames that are missing, and write them; returns how many were there from before.

    The same job goes on where it was interrupted, be it by ``kill -9``. Raises FormatError when a file cannot be written.
    """
    cameras = list(job.flight or orbit(job.camera, job.scene, job.count))
    past = {0: History()}

    def drawn(index: int) -> Picture:
        bits = 8 if job.animated or len(job.aovs) == 1 else 16  # of pictures alone, or of arrays too
        history = (past.get(index) or _went_on(job, index)) if job.averaged else None
        made = renderer.render(
            job.scene, cameras[index], job.size, job.settings, aovs=job.aovs, visibility_bits=bits, history=history
        )
        if history is not None:
            past.clear()
            past[index + 1] = history
            if index + 1 < job.count:
                history.save(job.before(index + 1))
            job.before(index - 1).unlink(missing_ok=True)  # a kill before this frame is written wants that of it
        return made

    return (_animate if job.animated else _fill)(job, job.identity(renderer), drawn, track)


def _animate(job: Turntable, identity: str, drawn: Callable[[int], Picture], track: Indices) -> int:
    """Draw the frames one below the other into an array that grows on disk, and make an animation of it."""
    w, h = job.size
    with TileCanvas(job.kept, (w, h * job.count), identity, job.output) as canvas:
        before = canvas.done
        for index in track(range(before, job.count)):
            canvas.add(PixelRect(0, h * (job.count - 1 - index), w, h), {"frames": drawn(index).as_png(job.aovs[0])})
        whole = np.load(canvas.path("frames"), mmap_mode="r")
        save_frames(job.output, [np.array(whole[top : top + h]) for top in range(0, h * job.count, h)])
        del whole
        canvas.remove()
    return before


def _went_on(job: Turntable, index: int) -> History:
    """Return what a turn that was cut before frame ``index`` left. Raises FormatError."""
    if not job.before(index).exists():
        raise FormatError(
            f"{job.before(index)}: is missing, so the frames cannot go on; remove {job.kept}, and they begin anew"
        )
    return History.load(job.before(index))


def _fill(job: Turntable, identity: str, drawn: Callable[[int], Picture], track: Indices) -> int:
    """Draw the frames to their places, with a note beside them of which are of this turn."""
    with new_folder(job.output), locked_folder(job.output):
        state = read_state(job.kept)
        done = state["done"] if state.get("identity") == identity else 0
        before = next((index for index in range(done) if not job.frame(index).exists()), done)
        for index in track(range(before, job.count)):
            drawn(index).save(job.frame(index))
            with atomic_write(job.kept) as temporary:
                temporary.write_text(json.dumps({"identity": identity, "done": index + 1}), "utf-8")
        job.kept.unlink(missing_ok=True)
        for left in job.output.glob(f"{HISTORY}*.npz"):
            left.unlink(missing_ok=True)
    return before


def orbit(camera: Camera, scene: Scene, count: int) -> Iterator[Camera]:
    """Give ``count`` cameras evenly around the scene's middle, about its up axis, starting with ``camera``."""
    center, up = scene.bounds.mean(0), np.asarray(scene.up, np.float64)
    x, y, z = up / np.linalg.norm(up)
    skew: Any = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    for index in range(count):
        angle = 2 * math.pi * index / count
        turn = np.eye(4)
        turn[:3, :3] += math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew  # Rodrigues
        turn[:3, 3] = center - turn[:3, :3] @ center
        yield dataclasses.replace(camera, pose=turn @ camera.pose)
