"""What is said of a frame beside its pixels: by what it was drawn, under which settings, by which plan."""

from __future__ import annotations

import functools
import importlib.metadata
from collections.abc import Sequence
from typing import Any

from ..gl.context import Context
from ..gl.executor import FrameExecutor
from ..pipeline.outputs import MASKS
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.labels import scene_labels
from ..scene.model import Scene
from ..scene.projection import Size


def frame_report(ctx: Context, settings: Settings, size: Size, frame: FrameExecutor, seconds: float) -> dict[str, Any]:
    """Return the report of a frame as plain values. seconds: from its start to its pixels."""
    return {
        "version": _version(),
        "settings": settings.table(),
        "size": list(size),
        "provider": ctx.provider,
        "platform": ctx.platform,
        "renderer": ctx.renderer,
        "gl_version": ctx.version,
        "plan": frame.plan.describe().splitlines(),
        "seconds": seconds,
    }


def scene_report(scene: Scene, camera: Camera, aovs: Sequence[str]) -> dict[str, Any]:
    """Return what is said of a scene and its camera; with masks also the names of what their numbers stand for."""
    about = {"camera": camera.name or "unnamed", "scene": scene.name, "triangles": scene.triangles, "contents": scene.contents}
    if not set(MASKS) & set(aovs):
        return about
    labels = scene_labels(scene)
    return about | {"labels": {"object": dict(labels.objects), "material": dict(labels.materials)}}


@functools.cache
def _version() -> str:
    return importlib.metadata.version("ssao_gl")  # which reads a file
