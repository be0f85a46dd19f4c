"""What runs on the workers of a cluster; needs dask.distributed."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Sequence
from typing import Any

from distributed import WorkerPlugin, get_worker

from ..errors import SettingsError
from ..io.fingerprint import code_fingerprint
from .jobs import ViewJob
from .painter import Painter
from .places import Place
from .rows import Row


def talkers() -> list[str]:
    """Return the names of the cluster's loggers."""
    return [name for name in logging.root.manager.loggerDict if name.split(".")[0] in ("distributed", "tornado")]


class PainterPlugin(WorkerPlugin):
    """Keeps one painter on a worker for as long as that lives; it is made where it draws first."""

    def __init__(self, provider: str, *, ours: bool) -> None:
        """``ours``: whether the worker was started by this batch, and is to be silent and end with it alone."""
        self.name = f"ssao_gl-{provider}"
        self._provider, self._ours = provider, ours
        self._painter: Painter | None = None

    def setup(self, worker: Any) -> None:
        """Open nothing yet: not every worker may be given jobs."""
        self._making = threading.Lock()
        logging.getLogger("ssao_gl").setLevel(logging.ERROR)  # warnings are in the rows
        if self._ours:
            for name in talkers():
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends this process

    def teardown(self, worker: Any) -> None:
        """Free the context."""
        if self._painter is not None:
            self._painter.release()

    @property
    def painter(self) -> Painter:
        """The painter. Raises ContextError when there is no OpenGL."""
        with self._making:  # a worker may have several threads
            if self._painter is None:
                self._painter = Painter(self._provider)
            return self._painter


def draw_chunk(chunk: Sequence[ViewJob], place: Place, plugin: str, code: str) -> list[Row]:
    """Draw jobs on a worker. ``code``: fingerprint of the client's. Raises SettingsError when the worker's is another."""
    worker = get_worker()
    if code_fingerprint() != code:
        raise SettingsError(f"the worker {worker.address} has another version of ssao_gl than this machine; install the same")
    kept = worker.plugins[plugin]
    assert isinstance(kept, PainterPlugin)
    painter = kept.painter
    return [painter.draw(job, place) for job in chunk]
