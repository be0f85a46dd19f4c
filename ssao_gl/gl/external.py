"""Textures and framebuffers of the caller's program, known to us by their GL names alone."""

from __future__ import annotations

import ctypes
from collections.abc import Collection
from types import TracebackType

from ..errors import FormatError
from ..scene.projection import Size
from .context import Context
from .guest_state import MAX_DRAW_BUFFERS, TEXTURE0, TEXTURE_2D

I, U, P, B = ctypes.c_int, ctypes.c_uint, ctypes.c_void_p, ctypes.c_ubyte

FRAMEBUFFER, COLOR_ATTACHMENT0, DRAW_BUFFER0, COMPLETE = 0x8D40, 0x8CE0, 0x8825, 0x8CD5
ATTACHMENT_TYPE, ATTACHMENT_NAME, TEXTURE = 0x8CD0, 0x8CD1, 0x1702
TEXTURE_WIDTH, TEXTURE_HEIGHT = 0x1000, 0x1001


def texture_size(ctx: Context, name: int) -> Size | None:
    """(width, height) of the 2-D texture ``name``, or None on OpenGL ES 3.0, which cannot tell. Binds it to unit 0.

    Raises FormatError when there is no such 2-D texture.
    """
    gl = ctx.functions
    if not gl("glIsTexture", B, U)(name):
        raise FormatError(f"Effect: this context has no texture with the GL name {name}")
    gl("glActiveTexture", None, U)(TEXTURE0)
    bind = gl("glBindTexture", None, U, U)
    bind(TEXTURE_2D, 0)  # what stays bound if the name belongs to another kind of texture
    bind(TEXTURE_2D, name)
    if ctx.api == "es" and ctx.mgl.version_code < 310:
        return None
    size = (I * 2)()
    query = gl("glGetTexLevelParameteriv", None, U, I, U, P)
    query(TEXTURE_2D, 0, TEXTURE_WIDTH, ctypes.addressof(size))
    query(TEXTURE_2D, 0, TEXTURE_HEIGHT, ctypes.addressof(size) + 4)
    if not size[0]:
        gl("glGetError", U)()  # the refused binding is reported here, not to the caller
        raise FormatError(f"Effect: the texture with the GL name {name} is no 2-D texture with an image at level 0")
    return size[0], size[1]


class GuestFramebuffer:
    """A framebuffer of the caller's to draw into, at its lower left corner; 0 is the window.

    Drawn into is its first colour attachment; inside ``with``, its other draw buffers are off. Raises FormatError when it
    cannot be drawn into, or when one of the textures ``read`` is attached to it.
    """

    def __init__(self, ctx: Context, name: int, size: Size, read: Collection[int] = ()) -> None:
        self._gl, self.name, self._size, self._read = ctx.functions, name, size, read

    def __enter__(self) -> GuestFramebuffer:
        gl = self._gl
        if self.name and not gl("glIsFramebuffer", B, U)(self.name):
            raise FormatError(f"Effect: this context has no framebuffer with the GL name {self.name}")
        gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, self.name)
        status = gl("glCheckFramebufferStatus", U, U)(FRAMEBUFFER)
        if status != COMPLETE:
            raise FormatError(f"Effect: the target, framebuffer {self.name}, is incomplete (0x{status:04x})")
        if self.name:
            self._check_loop()
            count = gl.integers(MAX_DRAW_BUFFERS)[0]
            self._buffers = [gl.integers(DRAW_BUFFER0 + i)[0] for i in range(count)]
            self._draw_buffers([COLOR_ATTACHMENT0])
        return self

    def use(self) -> None:
        """Make it what is drawn into."""
        gl = self._gl
        gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, self.name)
        gl("glViewport", None, I, I, I, I)(0, 0, *self._size)
        gl("glColorMask", None, B, B, B, B)(1, 1, 1, 1)
        gl("glDepthMask", None, B)(0)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.name:
            self._gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, self.name)
            self._draw_buffers(self._buffers)

    def _draw_buffers(self, buffers: list[int]) -> None:
        array = (U * len(buffers))(*buffers)
        self._gl("glDrawBuffers", None, I, P)(len(buffers), ctypes.addressof(array))

    def _check_loop(self) -> None:
        kind, name = I(), I()
        query = self._gl("glGetFramebufferAttachmentParameteriv", None, U, U, U, P)
        query(FRAMEBUFFER, COLOR_ATTACHMENT0, ATTACHMENT_TYPE, ctypes.addressof(kind))
        if kind.value == 0:
            raise FormatError(f"Effect: the target, framebuffer {self.name}, has no first colour attachment")
        query(FRAMEBUFFER, COLOR_ATTACHMENT0, ATTACHMENT_NAME, ctypes.addressof(name))
        if kind.value == TEXTURE and name.value in self._read:
            raise FormatError(
                f"Effect: the colour texture is attached to the target, framebuffer {self.name}; draw into another"
            )
