"""Jobs drawn by a cluster of dask.distributed: the same jobs, by the same painter, one on each of its worker processes."""

from __future__ import annotations

import logging
import queue
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from ..errors import SettingsError, SsaoError, one_line
from ..io.fingerprint import code_fingerprint
from .jobs import ViewJob
from .places import Place
from .rows import Row, failure

A_TASK = 8
"""Jobs of one scene that go to a worker together, so that it reads the scene once."""
RETRIES = 2
ANSWER = 10.0
"""Seconds to wait for a scheduler to answer."""
LOST = 5.0
"""Seconds without the scheduler until it is given up."""


def draw_on_cluster(jobs: Sequence[ViewJob], place: Place, provider: str, address: str) -> Iterator[Row]:
    """Draw jobs on the cluster at ``address``, or on one of N processes here by ``local:N``; yield their rows as they come.

    A worker that dies is replaced by the scheduler, and its jobs are tried elsewhere. Raises SettingsError when there is no
    scheduler, SsaoError when it is lost.
    """
    with _client(address) as client:
        from .cluster_worker import PainterPlugin, draw_chunk

        plugin = PainterPlugin(provider, ours=_is_local(address))
        client.register_plugin(plugin, name=plugin.name)
        done: queue.Queue[Any] = queue.Queue()
        waiting = {}
        for chunk in _chunks(jobs):
            key = f"ssao_gl-{chunk[0].identity}-{chunk[-1].identity}"
            future = client.submit(draw_chunk, chunk, place, plugin.name, code_fingerprint(), key=key, retries=RETRIES)
            waiting[future.key] = (future, chunk)
        for future, _ in waiting.values():
            future.add_done_callback(done.put)
        while waiting:
            future = _next(client, done, address, sum(len(chunk) for _, chunk in waiting.values()))
            if future is not None and future.key in waiting:
                yield from _rows(future, waiting.pop(future.key)[1], client, address)


def _next(client: Any, done: queue.Queue[Any], address: str, left: int) -> Any:
    """Return a future that has ended, or None after a while. Raises SsaoError when the scheduler is gone."""
    try:
        return done.get(timeout=LOST)
    except queue.Empty:
        if client.status != "running" or client.scheduler_comm is None or client.scheduler_comm.comm.closed():
            raise _lost(address, left) from None
        return None


def _lost(address: str, left: int) -> SsaoError:
    return SsaoError(
        f"the scheduler at {address} is gone; {left} views were not reported; the same command goes on with the rest"
    )


def _rows(future: Any, chunk: Sequence[ViewJob], client: Any, address: str) -> Sequence[Row]:
    """Return the rows of a future that has ended."""
    if future.status == "finished":
        found: Sequence[Row] = future.result(timeout=60)
        return found
    if future.status in ("cancelled", "lost"):
        raise _lost(address, len(chunk))
    error = future.exception(timeout=60)
    if isinstance(error, SsaoError):
        raise error
    why = (
        "workers that drew it ended, again and again; out of memory?"
        if type(error).__name__ == "KilledWorker"
        else one_line(error)
    )
    return [failure(job, f"the cluster: {why}") for job in chunk]


def _chunks(jobs: Sequence[ViewJob]) -> Iterator[list[ViewJob]]:
    """Yield jobs of one scene, a few each."""
    chunk: list[ViewJob] = []
    for job in jobs:
        if chunk and (job.scene != chunk[0].scene or len(chunk) == A_TASK):
            yield chunk
            chunk = []
        chunk.append(job)
    if chunk:
        yield chunk


def _is_local(address: str) -> bool:
    return address.partition(":")[0] == "local"


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """Yield a client of the scheduler, or of a cluster that is made here and ends with the block."""
    try:
        import distributed
    except ImportError:
        raise SettingsError(f"--dask {address}: needs the package distributed: pip install 'ssao_gl[cluster]'") from None
    made: Any = distributed
    with ExitStack() as ended:
        ended.enter_context(_hushed())
        where: Any = address
        if _is_local(address):
            number = address.partition(":")[2]
            count = int(number) if number.isascii() and number.isdigit() and int(number) else None
            where = ended.enter_context(made.LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None))
        try:
            client = made.Client(where, timeout=ANSWER, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise SettingsError(f"--dask {address}: no scheduler answers there ({one_line(error, 120)})") from None
        ended.callback(client.close, timeout=5)
        yield client


@contextmanager
def _hushed() -> Iterator[None]:
    """Keep the cluster's log of lost connections quiet within the block: what matters becomes one line of ours."""
    from .cluster_worker import talkers

    before = {name: logging.getLogger(name).level for name in talkers()}
    for name in before:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)
