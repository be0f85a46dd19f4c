"""Ctrl-C and SIGTERM end a command as an exception does, so that half-written files are removed on the way."""

from __future__ import annotations

import inspect
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Any

from ..io.atomic import replaced

CALLBACKS = "ssao_gl.gl.loader"
"""Module of the functions that OpenGL calls back: ctypes reports what they raise, and goes on."""
IMPORTING = "<frozen importlib"
"""File of the functions that import: several packages take whatever ends an import of theirs for a package that is missing."""
LATER = 0.002
"""Seconds until a signal is tried again that came during one of them."""
CLAIMING = inspect.unwrap(replaced).__code__
"""Code that makes, moves and removes temporary files."""
SWALLOWERS = "trimesh"
"""Package whose readers take whatever is raised for a fault of the file, and go on."""
AGAIN = 0.1
"""Seconds until a signal is raised again that came there and has not ended the command."""

Handler = Callable[[int, FrameType | None], Any]


class Terminated(SystemExit):
    """SIGTERM came; the exit code is 143."""


@contextmanager
def raised() -> Iterator[None]:
    """SIGTERM raises Terminated and SIGINT, unless it is ignored, KeyboardInterrupt, where nothing swallows them."""
    with ExitStack() as before:
        before.enter_context(_unswallowed())
        if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
            before.enter_context(_handled(signal.SIGINT, signal.default_int_handler))
        before.enter_context(_handled(signal.SIGTERM, _terminate))
        yield


def _terminate(number: int, frame: object) -> None:
    raise Terminated(128 + number)


def _later(number: int, seconds: float = LATER) -> threading.Timer:
    timer = threading.Timer(seconds, signal.raise_signal, (number,))
    timer.start()
    return timer


@contextmanager
def _unswallowed() -> Iterator[None]:
    """Try a signal again that came to a finalizer or a callback of C: what they raise is only reported."""

    def hook(found: sys.UnraisableHookArgs) -> None:
        if isinstance(found.exc_value, KeyboardInterrupt | Terminated):
            _later(signal.SIGTERM if isinstance(found.exc_value, Terminated) else signal.SIGINT)
        else:
            before(found)

    before, sys.unraisablehook = sys.unraisablehook, hook
    try:
        yield
    finally:
        sys.unraisablehook = before


@contextmanager
def _handled(number: signal.Signals, handler: Handler) -> Iterator[None]:
    with ExitStack() as armed:

        def handle(number: int, frame: FrameType | None) -> None:
            frames = list(_frames(frame))
            if any(one.f_code is CLAIMING or _reported_only(one) for one in frames):
                _later(number)
                return
            if any(str(one.f_globals.get("__name__")).split(".")[0] == SWALLOWERS for one in frames):
                armed.callback(_later(number, AGAIN).cancel)
            handler(number, frame)

        try:
            before = signal.signal(number, handle)
        except ValueError:  # only the main thread may
            yield
            return
        try:
            yield
        finally:
            signal.signal(number, before)


def _frames(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back


def _reported_only(frame: FrameType) -> bool:
    return frame.f_globals.get("__name__") == CALLBACKS or frame.f_code.co_filename.startswith(IMPORTING)
