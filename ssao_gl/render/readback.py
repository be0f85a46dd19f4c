"""What comes back from a drawn frame: the arrays of a picture, and how long the passes took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..gl.executor import WHOLE, DrawnFrame, FrameExecutor, SceneView
from ..gl.timer import PassTime
from ..graph.names import DEPTH, NORMAL
from ..graph.regions import DrawRegion
from ..io.images import flipped
from ..passes.resolve import resolved
from ..pipeline.outputs import MASKS, RESOURCES
from ..scene.projection import ViewConstants


def read_aov(frame: DrawnFrame, name: str, *, alpha: bool = False) -> NDArray[Any]:
    """Return an AOV of a drawn frame, as :class:`Picture` documents it."""
    resource = RESOURCES[name]
    if name == "normal" and resource not in frame.plan.where:  # arrays come with one kind of normals
        resource = NORMAL
    array = _read(frame, resource)
    if name == "visibility":
        held = array[..., 0]
        return held.astype(np.float32) / 255 if held.dtype == np.uint8 else np.clip(held, 0, 1)
    if name == "depth":
        return array[..., 0]
    if name in MASKS:
        return np.ascontiguousarray(array[..., MASKS[name]])
    if name in ("normal", "bent"):
        f = np.minimum((array**2).sum(-1, keepdims=True), 4)
        normal = np.concatenate([array * np.sqrt(1 - f / 4), 1 - f / 2], -1)
        return np.where(_read(frame, DEPTH) > 0, normal, 0).astype(np.float32)
    return array if alpha else np.ascontiguousarray(array[..., :3])


def _read(frame: DrawnFrame, resource: str) -> NDArray[Any]:
    """Return a resource with row 0 on top; of several samples a pixel, what they were resolved to."""
    one = resolved(resource)
    return flipped(frame.read(one if one in frame.plan.where else resource))


def time_passes(
    frame: FrameExecutor,
    rounds: int,
    view: ViewConstants,
    inputs: Mapping[str, Any] | None = None,
    *,
    scene: SceneView | None = None,
    region: DrawRegion = WHOLE,
) -> dict[str, Any]:
    """Return median milliseconds over ``rounds`` frames, as plain values; nothing for no rounds.

    Of each pass (``cpu_ms``: of the CPU's threads), of the G-buffer, and of everything after it.
    """
    runs = [frame.run(view, inputs, scene=scene, region=region, timed=True).times for _ in range(rounds)]
    if not runs:
        return {}
    medians = [_median([run[i].ms for run in runs]) for i in range(len(runs[0]))]
    work = [_median([run[i].cpu_ms for run in runs]) for i in range(len(runs[0]))]
    passes: Sequence[PassTime] = runs[0]
    before = sum(ms for one, ms in zip(passes, medians, strict=True) if one.role == "gbuffer")
    return {
        "passes": [
            {"name": one.name, "role": one.role, "ms": ms, "cpu_ms": cpu}
            for one, ms, cpu in zip(passes, medians, work, strict=True)
        ],
        "gbuffer_ms": before,
        "ao_ms": sum(medians) - before,
        "clock": passes[0].clock,
        "rounds": rounds,
    }


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))
