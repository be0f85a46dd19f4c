"""Signals that come while something must be finished first."""

from __future__ import annotations

import ctypes
import os
import signal
import time
from contextlib import ExitStack
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

from ssao_gl.cli import signals
from ssao_gl.io.atomic import atomic_write


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


def test_a_temporary_file_is_noted_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal between the making of a file and the note of it would leave the file behind."""
    before = os.open

    def opened(*arguments: Any) -> int:
        handle = before(*arguments)
        signal.raise_signal(signal.SIGTERM)
        return handle

    with pytest.raises(SystemExit), signals.raised(), ExitStack() as stack:
        monkeypatch.setattr(os, "open", opened)
        stack.callback(monkeypatch.undo)
        with atomic_write(tmp_path / "a.txt"):
            monkeypatch.undo()
            assert [path.name for path in tmp_path.iterdir()] == [".a.part.txt"]
            time.sleep(10)
    assert not list(tmp_path.iterdir())
