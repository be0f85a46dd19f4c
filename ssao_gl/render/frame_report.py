"""What is said of a frame beside its pixels: by what it was drawn, under which settings, by which plan."""

from __future__ import annotations

import functools
import importlib.metadata
from typing import Any

from ..gl.context import Context
from ..gl.executor import FrameExecutor
from ..pipeline.settings import Settings
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


@functools.cache
def _version() -> str:
    return importlib.metadata.version("ssao_gl")  # which reads a file
