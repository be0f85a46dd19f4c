"""Processes: what a fork leaves of an OpenGL library, and the memory that a driver has freed."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from functools import cache

from ..errors import ContextError

SINGLE_THREADED, SINGLE_THREADED_RENDERER = "LP_NUM_THREADS", "llvmpipe"
"""Mesa's software renderer draws without worker threads where this is 0. Then nothing is missing after a fork."""


_PROCESSES: dict[int, bool] = {}
"""Each process that opens contexts, and whether these survive a fork. Children inherit what their parents know."""


def note_renderer(renderer: str) -> None:
    """Remember the renderer of a context of this process: one that draws by threads of its own does not survive a fork."""
    if not renderer.startswith(SINGLE_THREADED_RENDERER):
        _PROCESSES[os.getpid()] = False


def check_process() -> None:
    """Raise ContextError in a child that was forked after a context had been opened: to draw there would wait for ever.

    A fork copies memory and one thread; the threads that draw for Mesa's software renderer, and a GPU driver's, are not copied.
    """
    _PROCESSES.setdefault(os.getpid(), os.environ.get(SINGLE_THREADED) == "0")
    if not all(survives for process, survives in _PROCESSES.copy().items() if process != os.getpid()):
        raise ContextError(
            "this process was forked from one that had opened OpenGL, which does not survive that: start it by 'spawn' "
            "(multiprocessing.get_context('spawn'), or DataLoader(multiprocessing_context='spawn')), "
            f"or set {SINGLE_THREADED}=0 before the first Renderer to let Mesa's {SINGLE_THREADED_RENDERER} draw in one thread"
        )


@cache
def skip_exit_handlers_of_children() -> None:
    """Let forked children end without the exit handlers of C libraries: OSMesa's waits for threads that are not there."""
    if not hasattr(os, "register_at_fork"):
        return
    libc = ctypes.CDLL(None)
    if hasattr(libc, "on_exit"):  # glibc's; handlers run in reverse order, and this one ends the process
        os.register_at_fork(after_in_child=lambda: libc.on_exit(libc._exit, None))


def return_freed_memory() -> None:
    """Give what the C library keeps of freed memory back to the system, where it is glibc's, which keeps a driver's by the GiB."""
    if trim := _malloc_trim():
        trim(0)


@cache
def _malloc_trim() -> Callable[[int], int] | None:
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
