"""Scissor, depth test and blending of a pass: on for its draw, off after it."""

from __future__ import annotations

import ctypes

from ..graph.plan import PlannedPass
from ..graph.regions import Rect
from .context import Context

GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_BLEND = 0x0B71, 0x0C11, 0x0BE2
GL_LESS, GL_GREATER, GL_GEQUAL, GL_ALWAYS = 0x0201, 0x0204, 0x0206, 0x0207
GL_ONE, GL_FUNC_ADD = 1, 0x8006


class DrawState:
    """``with state(step, rect):`` a draw goes through the pass's depth test, or writes its depth buffer, inside ``rect``."""

    def __init__(self, ctx: Context) -> None:
        gl = ctx.functions
        self._enable, self._disable = gl("glEnable", None, ctypes.c_uint), gl("glDisable", None, ctypes.c_uint)
        self._func = gl("glDepthFunc", None, ctypes.c_uint)
        self._scissor = gl("glScissor", None, *[ctypes.c_int] * 4)
        self._blend_func = gl("glBlendFunc", None, ctypes.c_uint, ctypes.c_uint)
        self._blend_equation = gl("glBlendEquation", None, ctypes.c_uint)
        self._depth = self._cut = self._add = False

    def __call__(self, step: PlannedPass, rect: Rect | None) -> DrawState:
        """Set what the pass asks for. ``rect``: in texels of its target; None: all of it."""
        task = step.task
        self._depth, self._cut, self._add = bool(task.test or task.depth), rect is not None, task.blend == "add"
        if self._depth:
            self._enable(GL_DEPTH_TEST)
            self._func((GL_GEQUAL if task.test.equal else GL_GREATER) if task.test else GL_ALWAYS)
        if rect:
            self._enable(GL_SCISSOR_TEST)
            self._scissor(*rect)
        if self._add:
            self._enable(GL_BLEND)
            self._blend_equation(GL_FUNC_ADD)
            self._blend_func(GL_ONE, GL_ONE)
        return self

    def nearest_surface(self) -> DrawState:
        """Keep the nearest surface of what is drawn, everywhere."""
        self._depth, self._cut, self._add = True, False, False
        self._enable(GL_DEPTH_TEST)
        return self

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        if self._depth:
            self._disable(GL_DEPTH_TEST)
            self._func(GL_LESS)
        if self._cut:
            self._disable(GL_SCISSOR_TEST)
        if self._add:
            self._disable(GL_BLEND)
