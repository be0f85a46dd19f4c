"""How the targets of a pass are cleared."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Protocol

from ..graph.plan import PlannedPass
from .context import Context
from .frame_targets import GL_COLOR

GL_DEPTH = 0x1801


class DrawTarget(Protocol):
    """What a pass draws into: a framebuffer of the frame, or one of the caller's."""

    def use(self) -> None:
        """Bind it."""


def clear_targets(ctx: Context, step: PlannedPass, target: DrawTarget, values: Mapping[str, Sequence[float]]) -> None:
    """Fill the targets of a step with what is left where nothing is drawn; those that are drawn over stay."""
    # Values are passed as they are: the address of one that nobody holds may be another thread's memory by the time of the call.
    target.use()
    gl, size = ctx.functions, ctypes.c_int
    clear = gl("glClearBufferfv", None, ctypes.c_uint, size, ctypes.c_void_p)
    for index, name in enumerate(step.writes):
        if name in step.task.over:
            continue
        if step.task.writes[name].format.endswith("ui"):
            integers = (ctypes.c_uint * 4)(*map(int, values[name]))
            gl("glClearBufferuiv", None, ctypes.c_uint, size, ctypes.c_void_p)(GL_COLOR, index, integers)
        else:
            clear(GL_COLOR, index, (ctypes.c_float * 4)(*values[name]))
    if step.task.depth:
        clear(GL_DEPTH, 0, ctypes.byref(ctypes.c_float(1.0)))
