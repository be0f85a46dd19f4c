"""What comes back from a drawn frame: the arrays of a picture, and how long the passes took."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..gl.executor import FrameExecutor
from ..gl.timer import PassTime
from ..io.images import flipped
from ..pipeline.outputs import RESOURCES
from ..scene.projection import ViewConstants


def read_aov(frame: FrameExecutor, name: str, *, alpha: bool = False) -> NDArray[Any]:
    """An AOV of a drawn frame, as :class:`Picture` documents it."""
    resource = RESOURCES[name]
    if resource not in frame.plan.where:  # arrays come with one kind of normals
        resource = name
    array = flipped(frame.read(resource))
    if name == "visibility":
        return array[..., 0].astype(np.float32) / 255
    if name == "depth":
        return array[..., 0]
    if name in ("normal", "bent"):
        f = np.minimum((array**2).sum(-1, keepdims=True), 4)
        normal = np.concatenate([array * np.sqrt(1 - f / 4), 1 - f / 2], -1)
        return np.where(flipped(frame.read("z")) > 0, normal, 0).astype(np.float32)
    return array if alpha else np.ascontiguousarray(array[..., :3])


def time_passes(frame: FrameExecutor, rounds: int, view: ViewConstants, inputs: Any = None, **drawn: Any) -> dict[str, Any]:
    """Median milliseconds over ``rounds`` frames (``drawn``: see :meth:`FrameExecutor.run`): of each pass (and of the CPU's threads, ``cpu_ms``), of
    the G-buffer, and of everything after it."""
    runs: list[list[PassTime]] = []
    for _ in range(rounds):
        frame.run(view, inputs, **drawn, timed=True)
        runs.append(frame.times)
    if not runs:
        return {}
    medians = {p.name: float(np.median([run[i].ms for run in runs])) for i, p in enumerate(runs[0])}
    work = [float(np.median([run[i].cpu_ms for run in runs])) for i in range(len(runs[0]))]
    return {
        "passes": [{"name": name, "ms": ms, "cpu_ms": cpu} for (name, ms), cpu in zip(medians.items(), work, strict=True)],
        "gbuffer_ms": medians.get("gbuffer", 0.0),
        "ao_ms": sum(ms for name, ms in medians.items() if name != "gbuffer"),
        "clock": runs[0][0].clock,
        "rounds": rounds,
    }
