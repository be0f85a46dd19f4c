"""Who may use a context: the process that opened it, one thread at a time."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ..errors import ContextError
from .process import check_process

_TURNS: dict[int, threading.RLock] = {}
"""By process: a fork may copy a lock that nobody is left to unlock."""


def software_turns(process: int) -> threading.RLock:
    """Return the one lock of a process for all contexts of software renderers.

    Where two threads draw at the same time, each with a context of its own, Mesa's llvmpipe (22.3), SwiftShader and ANGLE on
    lavapipe now and then draw wrong pictures. They share the cores anyway, so that turns cost little.
    """
    return _TURNS.setdefault(process, threading.RLock())


@dataclass(slots=True, kw_only=True)
class Ownership:
    """The process and the thread that made a context, and the lock under which it is used.

    rebinds: whether it can be made current in any thread once no other one holds it. lock: contexts of software renderers share
    :func:`software_turns`.
    """

    rebinds: bool = False
    process: int = field(default_factory=os.getpid)
    thread: int = field(default_factory=threading.get_ident)
    lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def inherited(self) -> bool:
        """Whether this process got the context by a fork."""
        return self.process != os.getpid()

    @contextmanager
    def held(self, is_current: Callable[[], bool] | None = None) -> Iterator[None]:
        """Hold the context within the block; other threads wait. Raises ContextError where it cannot be used.

        is_current: tells whether a caller's own context is current in this thread; None for one that ssao_gl makes current.
        """
        check_process()
        if is_current is not None:
            if not is_current():
                raise ContextError("no OpenGL context is current in this thread; make yours current first")
        elif not self.rebinds and self.thread != threading.get_ident():
            raise ContextError("this context can be used only in the thread that made it: make one Renderer a thread")
        if not self.lock.acquire(blocking=not self.inherited):  # nobody is left to unlock it
            raise ContextError("this process was forked while another thread drew with this context: make a new Renderer")
        try:
            yield
        finally:
            self.lock.release()
