"""What passes take."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from .context import Context


@dataclass(frozen=True, slots=True)
class PassTime:
    """Milliseconds that a pass took, and by which clock."""

    name: str
    ms: float
    clock: str
    cpu_ms: float
    """Of all threads of this process: on a software renderer the work itself, whatever else the machine does."""
    role: str
    """What the pass is for; see :data:`ssao_gl.graph.declare.Role`."""


class Timer:
    """Times passes: by GL's own timer on a GPU that has one, else by waiting for each pass with the wall clock."""

    def __init__(self, ctx: Context) -> None:
        self._ctx = ctx
        self._gpu = ctx.gpu_timer
        self.clock = "gpu" if self._gpu else "wall"
        self._queries: list[Any] = []  # used again: moderngl never frees one
        self._passes: list[tuple[str, str]] = []
        self._waits: list[float | None] = []
        self._cpu: list[float] = []
        self._by_gpu = self._gpu
        self._began = self._cpu_began = 0.0

    def restart(self) -> None:
        """Forget what was timed."""
        self._passes, self._waits, self._cpu = [], [], []
        if not self._gpu:
            self._ctx.mgl.finish()

    def start(self, *, host: bool = False) -> None:
        """Begin a pass. ``host``: one that the host computes, by the wall clock whoever draws."""
        self._by_gpu = self._gpu and not host
        if self._by_gpu:
            if len(self._passes) >= len(self._queries):
                self._queries += [self._ctx.mgl.query(time=True) for _ in range(len(self._passes) + 1 - len(self._queries))]
            self._queries[len(self._passes)].mglo.begin()
        elif host:
            self._ctx.mgl.finish()
        self._began, self._cpu_began = time.perf_counter(), time.process_time()

    def stop(self, name: str, role: str) -> None:
        if self._by_gpu:
            self._queries[len(self._passes)].mglo.end()
            self._waits.append(None)
        else:
            self._ctx.mgl.finish()
            self._waits.append(1e3 * (time.perf_counter() - self._began))
        self._passes.append((name, role))
        self._cpu.append(1e3 * (time.process_time() - self._cpu_began))

    def results(self) -> list[PassTime]:
        found = []
        for index, ((name, role), wait, cpu) in enumerate(zip(self._passes, self._waits, self._cpu, strict=True)):
            ms, clock = (self._queries[index].elapsed * 1e-6, "gpu") if wait is None else (wait, "wall")
            found.append(PassTime(name, ms, clock, cpu, role))
        return found
