"""Signals that come while OpenGL calls back into Python."""

from __future__ import annotations

import ctypes
import signal
import time
from types import FunctionType

import pytest

from ssao_gl.cli import signals


@pytest.mark.parametrize(("number", "error"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_callback_is_finished_first(number: signal.Signals, error: type[BaseException]) -> None:
    """ctypes only reports what a callback raises, and goes on."""
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored by what a background shell starts
    done = []

    def body() -> None:
        signal.raise_signal(number)
        done.append("finished")

    theirs = {"signal": signal, "number": number, "done": done, "__name__": signals.CALLBACKS, "__builtins__": __builtins__}
    callback = ctypes.CFUNCTYPE(None)(FunctionType(body.__code__, theirs, closure=body.__closure__))
    try:
        with pytest.raises(error), signals.raised():
            callback()
            assert done == ["finished"]
            time.sleep(10)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def test_elsewhere_at_once() -> None:
    with pytest.raises(SystemExit), signals.raised():
        signal.raise_signal(signal.SIGTERM)
        pytest.fail("not raised")
