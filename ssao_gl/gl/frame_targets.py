"""The textures and framebuffers of a plan. Plans of one layout share them."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import moderngl

from ..errors import ContextError
from ..graph.declare import DEPTH_FORMAT
from ..graph.plan import Attachments, FrameLayout, Slot
from .programs import FORMATS, GpuResources

GL_COLOR = 0x1800


class FrameTargets:
    """GL objects for a layout. Raises ContextError when the driver cannot make them.

    Slots with a history come in pairs that change places: there is a set of framebuffers for even and one for odd frames.
    """

    def __init__(self, resources: GpuResources, layout: FrameLayout) -> None:
        self.layout, self._resources = layout, resources
        self.frames = 0
        """How many frames were drawn; the next one is even or odd by it."""
        self._owned: list[Any] = []
        ctx, (w, h) = resources.ctx, layout.frame
        if max(w, h) > ctx.max_size:
            raise ContextError(f"a frame of {w}x{h}: {ctx.renderer} draws at most {ctx.max_size} a side")
        try:
            slots = [self._make(slot) for slot in layout.slots]
            self._slots = [slots, _exchanged(slots, layout.history)]
            sides = self._slots if layout.history else self._slots[:1]
            self._framebuffers = [[self._framebuffer(side, one) for one in layout.attachments] for side in sides]
            for pair in layout.history:
                self._forget([slots[index] for index in pair])
        except BaseException as error:
            self.release()
            if not isinstance(error, moderngl.Error):
                raise
            raise ContextError(f"{ctx.renderer} cannot make the targets of {w}x{h}: {error}") from None

    @property
    def slots(self) -> Sequence[Any]:
        """Textures and depth buffers of the next frame, by slot."""
        return self._slots[self.frames % 2 if self.layout.history else 0]

    @property
    def framebuffers(self) -> Sequence[moderngl.Framebuffer]:
        """What each pass of the next frame draws into."""
        return self._framebuffers[self.frames % 2 if self.layout.history else 0]

    def _make(self, slot: Slot) -> Any:
        mgl = self._resources.ctx.mgl
        if slot.depth > 1:
            raise ContextError(f"a target of {slot.depth} layers: 3-D textures can be read, but not yet be drawn into")
        if slot.format == DEPTH_FORMAT:
            made: Any = mgl.depth_renderbuffer(slot.size)
        else:
            components, dtype = FORMATS[slot.format]
            made = mgl.texture(slot.size, components, dtype=dtype)
            made.filter = (moderngl.NEAREST, moderngl.NEAREST)
            made.repeat_x = made.repeat_y = False
        self._owned.append(made)
        return made

    def _framebuffer(self, slots: Sequence[Any], one: Attachments) -> moderngl.Framebuffer:
        depth = None if one.depth_slot is None else slots[one.depth_slot]
        made = self._resources.ctx.mgl.framebuffer([slots[slot] for slot in one.slots], depth)
        made.depth_mask = one.writes_depth
        self._owned.append(made)
        return made

    def _forget(self, textures: Sequence[moderngl.Texture]) -> None:
        """Fill textures with zeros: what the frame before the first one left."""
        clear = self._resources.ctx.functions("glClearBufferfv", None, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
        for texture in textures:
            framebuffer = self._resources.ctx.mgl.framebuffer([texture])
            framebuffer.use()
            clear(GL_COLOR, 0, (ctypes.c_float * 4)())
            self._resources.home.use()
            framebuffer.release()

    def release(self) -> None:
        """Free every texture and framebuffer. Calling it twice does no harm."""
        if self._owned:
            self._resources.home.use()
        for made in reversed(self._owned):
            made.release()
        self._owned = []


def _exchanged(slots: Sequence[Any], pairs: Sequence[tuple[int, int]]) -> list[Any]:
    """Return the slots with those of each pair in each other's place."""
    other = list(slots)
    for one, two in pairs:
        other[one], other[two] = slots[two], slots[one]
    return other
