"""EGL by ctypes: a context without a surface or a screen, for OpenGL ES or desktop OpenGL, from any libEGL."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

I, U, P, S = ctypes.c_int32, ctypes.c_uint32, ctypes.c_void_p, ctypes.c_char_p

EGL_NONE, EGL_TRUE = 0x3038, 1
EGL_SURFACE_TYPE, EGL_RENDERABLE_TYPE, EGL_PBUFFER_BIT = 0x3033, 0x3040, 0x0001
EGL_OPENGL_ES3_BIT, EGL_OPENGL_BIT = 0x0040, 0x0008
EGL_OPENGL_ES_API, EGL_OPENGL_API = 0x30A0, 0x30A2
EGL_MAJOR, EGL_MINOR, EGL_PROFILE_MASK, EGL_CORE_BIT = 0x3098, 0x30FB, 0x30FD, 1
EGL_WIDTH, EGL_HEIGHT = 0x3057, 0x3056
EGL_EXTENSIONS, EGL_DRAW, EGL_READ = 0x3055, 0x3059, 0x305A
EGL_PLATFORM_SURFACELESS, EGL_PLATFORM_DEVICE = 0x31DD, 0x313F
EGL_PLATFORM_ANGLE, EGL_PLATFORM_ANGLE_TYPE, EGL_PLATFORM_ANGLE_NATIVE_PLATFORM_TYPE = 0x3202, 0x3203, 0x348F
EGL_PLATFORM_ANGLE_TYPE_VULKAN = 0x3450
GL_VERSION = 0x1F02

Display = int
"""An ``EGLDisplay`` handle."""


@dataclass
class EglContext:
    """A live context. ``get_proc`` answers for it, ``make_current`` and ``release`` own its life.

    ``make_current`` returns, and ``leave`` is, what makes current again whatever was before, be it nothing: so the context is
    free for other threads.
    """

    platform: str
    get_proc: Callable[[str], int]
    make_current: Callable[[], Callable[[], None]]
    release: Callable[[], None]
    leave: Callable[[], None]


class Egl:
    """The functions of one libEGL. Raises OSError when the library is not there."""

    def __init__(self, library: str | None = None, client: str | None = None) -> None:
        path = library or ctypes.util.find_library("EGL") or "libEGL.so.1"
        self.client = ctypes.CDLL(client) if client else None
        self.lib = ctypes.CDLL(path)

    def function(self, name: str, result: Any, *arguments: Any) -> Any:
        function = getattr(self.lib, name)
        function.restype, function.argtypes = result, arguments
        return function

    def extension(self, name: str, result: Any, *arguments: Any) -> Any:
        """Return a function of an EGL extension, or None."""
        address = self.get_proc(name)
        return ctypes.CFUNCTYPE(result, *arguments)(address) if address else None

    def get_proc(self, name: str) -> int:
        """Address of a GL or EGL function; the client library is asked first where we were given one."""
        if self.client is not None:
            found = getattr(self.client, name, None)
            if found is not None:
                return ctypes.cast(found, P).value or 0
        address = self.function("eglGetProcAddress", P, S)(name.encode())
        return address or 0

    def error(self) -> str:
        return f"EGL error 0x{self.function('eglGetError', I)():04x}"

    def query(self, display: Display | None, name: int) -> str:
        text = self.function("eglQueryString", S, P, I)(display, name)
        return text.decode("ascii", "replace") if text else ""


def displays(egl: Egl) -> Iterator[tuple[str, Display]]:
    """Yield displays worth a try, best first: real GPUs, then Mesa's surfaceless platform, then software devices, then the
    default."""
    extensions = egl.query(None, EGL_EXTENSIONS)
    get = egl.extension("eglGetPlatformDisplayEXT", P, U, P, ctypes.POINTER(I))
    devices = _devices(egl, extensions)
    for index, device, software in devices:
        if not software and get:
            yield f"device {index}", get(EGL_PLATFORM_DEVICE, device, None)
    if get and "EGL_MESA_platform_surfaceless" in extensions:
        yield "surfaceless", get(EGL_PLATFORM_SURFACELESS, None, None)
    for index, device, software in devices:
        if software and get:
            yield f"device {index}", get(EGL_PLATFORM_DEVICE, device, None)
    yield "default display", egl.function("eglGetDisplay", P, P)(None)


def _devices(egl: Egl, extensions: str) -> list[tuple[int, int, bool]]:
    """(index, handle, is software) of each EGL device."""
    query = egl.extension("eglQueryDevicesEXT", U, I, P, P)
    if query is None or ("EGL_EXT_device" not in extensions and "EGL_EXT_platform_device" not in extensions):
        return []
    count = I()
    handles = (P * 32)()
    if not query(32, ctypes.addressof(handles), ctypes.addressof(count)):
        return []
    describe = egl.extension("eglQueryDeviceStringEXT", S, P, I)
    found = []
    for index in range(count.value):
        text = describe(handles[index], EGL_EXTENSIONS) if describe else b""
        found.append((index, handles[index] or 0, b"EGL_MESA_device_software" in (text or b"")))
    return found


def angle_display(egl: Egl) -> Iterator[tuple[str, Display]]:
    """ANGLE on Vulkan without a window system, then whatever ANGLE takes by itself (Metal, Direct3D)."""
    get = egl.extension("eglGetPlatformDisplayEXT", P, U, P, ctypes.POINTER(I))
    if get:
        wanted = (I * 5)(
            EGL_PLATFORM_ANGLE_TYPE,
            EGL_PLATFORM_ANGLE_TYPE_VULKAN,
            EGL_PLATFORM_ANGLE_NATIVE_PLATFORM_TYPE,
            EGL_PLATFORM_SURFACELESS,
            EGL_NONE,
        )
        yield "Vulkan, surfaceless", get(EGL_PLATFORM_ANGLE, None, wanted)
    yield "default display", egl.function("eglGetDisplay", P, P)(None)


def open_context(egl: Egl, candidates: Iterator[tuple[str, Display]], *, es: bool) -> EglContext:
    """Return the first display of ``candidates`` that gives a context of OpenGL ES >= 3.0 (or core >= 3.3); OSError says why
    none did."""
    reasons = []
    back = _way_back(egl)
    for platform, display in candidates:
        try:
            return _open_on(egl, platform, display, back, es=es)
        except OSError as reason:
            reasons.append(f"{platform}: {reason}")
    if back:
        back()
    raise OSError("; ".join(reasons) or "libEGL offers no display")


def _way_back(egl: Egl) -> Callable[[], None] | None:
    """Return what makes current again the context that is current now; None when there is none."""
    api = egl.function("eglQueryAPI", U)()
    context = egl.function("eglGetCurrentContext", P)()
    if not context:
        return None
    display = egl.function("eglGetCurrentDisplay", P)()
    draw, read = (egl.function("eglGetCurrentSurface", P, I)(which) for which in (EGL_DRAW, EGL_READ))

    def back() -> None:
        egl.function("eglBindAPI", U, U)(api)
        egl.function("eglMakeCurrent", U, P, P, P, P)(display, draw, read, context)

    return back


def _open_on(egl: Egl, platform: str, display: Display, before: Callable[[], None] | None, *, es: bool) -> EglContext:
    if not display:
        raise OSError("no display")
    if not egl.function("eglInitialize", U, P, P, P)(display, None, None):
        raise OSError(f"eglInitialize failed, {egl.error()}")
    if not egl.function("eglBindAPI", U, U)(EGL_OPENGL_ES_API if es else EGL_OPENGL_API):
        raise OSError(f"this EGL has no {'OpenGL ES' if es else 'desktop OpenGL'}")
    config = _config(egl, display, EGL_OPENGL_ES3_BIT if es else EGL_OPENGL_BIT)
    version = [EGL_MAJOR, 3, EGL_MINOR, 0] if es else [EGL_MAJOR, 3, EGL_MINOR, 3, EGL_PROFILE_MASK, EGL_CORE_BIT]
    attributes = (I * (len(version) + 1))(*version, EGL_NONE)
    context = egl.function("eglCreateContext", P, P, P, P, P)(display, config, None, attributes)
    if not context:
        raise OSError(f"no context of {'OpenGL ES 3.0' if es else 'OpenGL 3.3 core'}, {egl.error()}")
    surface = None
    if "EGL_KHR_surfaceless_context" not in egl.query(display, EGL_EXTENSIONS):
        size = (I * 5)(EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE)
        surface = egl.function("eglCreatePbufferSurface", P, P, P, P)(display, config, size)
    bind = egl.function("eglBindAPI", U, U)
    current = egl.function("eglMakeCurrent", U, P, P, P, P)

    which = egl.function("eglGetCurrentContext", P)
    get_string = egl.extension("glGetString", S, U)

    def unbind() -> None:
        bind(EGL_OPENGL_ES_API if es else EGL_OPENGL_API)
        current(display, None, None, None)

    def make_current() -> Callable[[], None]:
        back = (lambda: None) if which() == context else _way_back(egl) or unbind
        bind(EGL_OPENGL_ES_API if es else EGL_OPENGL_API)
        if which() == context and get_string and not get_string(GL_VERSION):  # OSMesa took it away, and EGL did not notice
            current(display, None, None, None)
        if which() != context and not current(display, surface, surface, context):
            raise OSError(f"eglMakeCurrent failed, {egl.error()}")
        return back

    def release() -> None:
        if which() == context:
            unbind()
        if surface:
            egl.function("eglDestroySurface", U, P, P)(display, surface)
        egl.function("eglDestroyContext", U, P, P)(display, context)

    make_current()
    return EglContext(platform, egl.get_proc, make_current, release, before or unbind)


def _config(egl: Egl, display: Display, renderable: int) -> int:
    """Return a config for contexts without a window: surfaceless where that exists, else with a pbuffer."""
    choose = egl.function("eglChooseConfig", U, P, P, P, I, P)
    for surface_type in (0, EGL_PBUFFER_BIT):
        wanted = (I * 5)(EGL_SURFACE_TYPE, surface_type, EGL_RENDERABLE_TYPE, renderable, EGL_NONE)
        found, count = P(), I()
        if choose(display, wanted, ctypes.addressof(found), 1, ctypes.addressof(count)) and count.value:
            return found.value or 0
    raise OSError(f"no config, {egl.error()}")
