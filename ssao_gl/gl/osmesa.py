"""OSMesa: Mesa's off-screen library, which needs no EGL and no window system (removed from Mesa 25.1, kept by many distributions)."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Callable
from typing import Any

from .egl import EglContext
from .process import skip_exit_handlers_of_children

I, P, S = ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p

OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, OSMESA_PROFILE, OSMESA_CORE_PROFILE = 0x22, 0x1908, 0x30, 0x33, 0x34
OSMESA_CONTEXT_MAJOR_VERSION, OSMESA_CONTEXT_MINOR_VERSION, GL_UNSIGNED_BYTE = 0x36, 0x37, 0x1401


def open_context() -> EglContext:
    """Return a core 3.3 (or later) context. Raises OSError with the reason."""
    lib = _library()
    skip_exit_handlers_of_children()

    def function(name: str, result: Any, *arguments: Any) -> Any:
        function = getattr(lib, name)
        function.restype, function.argtypes = result, arguments
        return function

    wanted = (I * 11)(
        OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 24, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
        OSMESA_CONTEXT_MAJOR_VERSION, 3, OSMESA_CONTEXT_MINOR_VERSION, 3, 0,
    )  # fmt: skip
    context = function("OSMesaCreateContextAttribs", P, P, P)(wanted, None)
    if not context:
        raise OSError("OSMesa gives no core 3.3 context")
    # A context needs a buffer to be current; everything of ours is drawn into framebuffer objects.
    pixels = ctypes.create_string_buffer(16 * 16 * 4)
    current = function("OSMesaMakeCurrent", ctypes.c_ubyte, P, P, I, I, I)
    address = function("OSMesaGetProcAddress", P, S)

    which = function("OSMesaGetCurrentContext", P)

    def leave() -> None:
        # OSMesa does not tell enough of another context to go back to it. But none may stay current in place of one of
        # EGL's: Mesa's libraries share what is current, and EGL would not notice.
        current(None, None, 0, 0, 0)

    def make_current() -> Callable[[], None]:
        back = (lambda: None) if which() == context else leave
        if not current(context, pixels, GL_UNSIGNED_BYTE, 16, 16):
            raise OSError("OSMesaMakeCurrent failed")
        return back

    def release() -> None:
        if which() == context:
            leave()
        function("OSMesaDestroyContext", None, P)(context)

    make_current()
    return EglContext("off-screen", lambda name: address(name.encode()) or 0, make_current, release, leave)


def _library() -> ctypes.CDLL:
    reasons = []
    for name in (ctypes.util.find_library("OSMesa"), "libOSMesa.so.8", "libOSMesa.so"):
        if name:
            try:
                return ctypes.CDLL(name)
            except OSError as reason:
                reasons.append(str(reason))
    raise OSError(reasons[0])
