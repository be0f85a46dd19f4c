"""Jobs drawn by processes of this machine: spawned, each with a context of its own, fed one job at a time.

A process that ends (by ``kill -9``, or the driver) takes one job with it, which is tried once more by a new process.
"""

from __future__ import annotations

import logging
import os
import signal
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from ..errors import ContextError, SsaoError
from .jobs import ViewJob
from .painter import Painter
from .places import Place
from .rows import Row, failure

TRIES = 2
"""Processes that a job may end."""
GRACE = 10.0
"""Seconds for a process to finish the job it is at when the batch is cut."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def draw_here(jobs: Sequence[ViewJob], place: Place, provider: str) -> Iterator[Row]:
    """Draw jobs in this process. Raises ContextError when there is no OpenGL."""
    painter = Painter(provider)
    try:
        for job in jobs:
            yield painter.draw(job, place)
    finally:
        painter.release()


def draw_local(jobs: Sequence[ViewJob], place: Place, provider: str, count: int) -> Iterator[Row]:
    """Draw jobs by ``count`` processes, and yield their rows as they come. Raises ContextError when there is no OpenGL."""
    queue = JobQueue(jobs)
    crew: dict[Connection, Worker] = {}
    try:
        with _shared_cores(count):
            for _ in range(min(count, len(jobs))):
                _hire(crew, place, provider)
            while crew:
                for ready in wait(list(crew)):
                    worker = crew[ready]  # type: ignore[index]
                    try:
                        row = worker.pipe.recv()
                    except (EOFError, OSError):
                        yield from _buried(crew, worker, queue, place, provider)
                        continue
                    if isinstance(row, SsaoError):
                        raise row
                    if row is not None:
                        yield row
                    _feed(crew, worker, queue)
    finally:
        _dismiss(crew)


@dataclass(eq=False)
class Worker:
    """A process, the pipe to it, and the job that it is at."""

    process: BaseProcess
    pipe: Connection
    job: ViewJob | None = None
    scene: Path | None = None
    began: bool = False


@dataclass(eq=False)
class JobQueue:
    """Jobs that wait, by scene: who has a scene goes on with it, else takes one that nobody is at, else helps with the largest rest."""

    jobs: Sequence[ViewJob]
    tries: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._waiting: dict[Path, deque[ViewJob]] = {}
        for job in self.jobs:
            self._waiting.setdefault(job.scene, deque()).append(job)

    def take(self, scene: Path | None, others: Sequence[Path | None]) -> ViewJob | None:
        """Return the next job for who holds ``scene`` while ``others`` are held elsewhere; None when none waits."""
        if not self._waiting:
            return None
        if scene not in self._waiting:
            free = (one for one in self._waiting if one not in others)
            scene = next(free, None) or max(self._waiting, key=lambda one: len(self._waiting[one]))
        job = self._waiting[scene].popleft()
        if not self._waiting[scene]:
            del self._waiting[scene]
        return job

    def again(self, job: ViewJob) -> bool:
        """Put a job back whose process ended; False when it has ended enough of them."""
        self.tries[job.name] = self.tries.get(job.name, 0) + 1
        if self.tries[job.name] >= TRIES:
            return False
        self._waiting.setdefault(job.scene, deque()).appendleft(job)
        return True

    def __bool__(self) -> bool:
        return bool(self._waiting)


def _hire(crew: dict[Connection, Worker], place: Place, provider: str) -> None:
    ours, theirs = get_context("spawn").Pipe()
    process = get_context("spawn").Process(target=_work, args=(theirs, place, provider), daemon=True)
    process.start()
    theirs.close()
    crew[ours] = Worker(process, ours)


def _feed(crew: dict[Connection, Worker], worker: Worker, queue: JobQueue) -> None:
    """Give a worker its next job, or let it go."""
    others = [other.scene for other in crew.values() if other is not worker]
    worker.job, worker.began = queue.take(worker.scene, others), True
    if worker.job is None:
        del crew[worker.pipe]
        worker.pipe.close()
        worker.process.join(GRACE)
        return
    worker.scene = worker.job.scene
    with suppress(OSError):  # it has just ended, which the pipe tells next
        worker.pipe.send(worker.job)


def _buried(crew: dict[Connection, Worker], worker: Worker, queue: JobQueue, place: Place, provider: str) -> Iterator[Row]:
    """Replace a process that has ended, and yield the row of its job if that is not tried again."""
    del crew[worker.pipe]
    worker.pipe.close()
    worker.process.join(GRACE)
    code = worker.process.exitcode or 0
    if not worker.began:
        raise ContextError(
            "a process ended before it could draw; in a program of your own, call batch() below if __name__ == '__main__':"
        )
    if worker.job is not None and not queue.again(worker.job):
        cause = f"by {signal.Signals(-code).name}; out of memory?" if code < 0 else f"with exit code {code}"
        yield failure(worker.job, f"the process that drew it ended {cause}")
    if queue:
        _hire(crew, place, provider)


def _dismiss(crew: Mapping[Connection, Worker]) -> None:
    """Let all go: each ends after the job that it is at, or is ended."""
    for worker in crew.values():
        worker.pipe.close()
    for worker in crew.values():
        worker.process.join(GRACE)
        if worker.process.is_alive():
            worker.process.kill()
            worker.process.join()


def _work(pipe: Connection, place: Place, provider: str) -> None:
    """Draw what comes through the pipe until it is closed. Ctrl-C is for the parent, which closes it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("ssao_gl").setLevel(logging.ERROR)  # warnings are in the rows
    try:
        painter = Painter(provider)
    except SsaoError as error:
        pipe.send(error)
        return
    with suppress(EOFError, OSError):
        pipe.send(None)
        while True:
            pipe.send(painter.draw(pipe.recv(), place))
    painter.release()


@contextmanager
def _shared_cores(count: int) -> Iterator[None]:
    """Share the cores among processes: of llvmpipe, which would start a thread a core in each. A number of the user's stays."""
    name, share = "LP_NUM_THREADS", cores() // count
    if name in os.environ or count < 2:
        yield
        return
    os.environ[name] = str(max(share, 1))  # none at all takes more of the processor, not less
    try:
        yield
    finally:
        del os.environ[name]
