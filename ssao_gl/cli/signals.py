"""Ctrl-C and SIGTERM end a command as an exception does, so that half-written files are removed on the way."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Any

CALLBACKS = "ssao_gl.gl.loader"
"""Module of the functions that OpenGL calls back."""
LATER = 0.002
"""Seconds until a signal is tried again that came during one of them."""

Handler = Callable[[int, FrameType | None], Any]


@contextmanager
def raised() -> Iterator[None]:
    """SIGTERM raises SystemExit and SIGINT, unless it is ignored, KeyboardInterrupt; neither within a callback of OpenGL.

    ctypes would swallow it there, and what the callback was to do would be left undone.
    """
    with ExitStack() as before:
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            before.enter_context(_handled(signal.SIGINT, signal.default_int_handler))
        before.enter_context(_handled(signal.SIGTERM, _leave))
        yield


def _leave(number: int, frame: object) -> None:
    raise SystemExit(128 + number)


@contextmanager
def _handled(number: signal.Signals, handler: Handler) -> Iterator[None]:
    def handle(number: int, frame: FrameType | None) -> None:
        if _called_back(frame):
            threading.Timer(LATER, signal.raise_signal, (number,)).start()
        else:
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


def _called_back(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_globals.get("__name__") == CALLBACKS:
            return True
        frame = frame.f_back
    return False
