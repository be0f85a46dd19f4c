"""How far a batch is: a bar with rate and remaining time on a terminal, plain lines elsewhere, JSON lines for programs."""

from __future__ import annotations

import json
import sys
import time
from types import TracebackType
from typing import Any

from ..batch.results import Results
from ..batch.rows import Row
from ..errors import SettingsError, near_miss
from .output import QUIET

KINDS = ("auto", "bar", "lines", "json", "none")
EVERY = 10.0
"""Seconds from line to line."""
MOST_CAUSES = 20
"""Different errors that are told of; the table has all."""


class Progress:
    """Is told of views as they come, and shows them. Raises SettingsError for a kind that is not there."""

    def __init__(self, kind: str) -> None:
        if kind not in KINDS:
            raise SettingsError(f"--progress {kind}: must be one of {', '.join(KINDS)}.{near_miss(kind, KINDS)}")
        automatic = "none" if QUIET.get() else "bar" if sys.stderr.isatty() else "lines"
        self._kind = automatic if kind == "auto" else kind
        self._started = self._said = time.monotonic()
        self._causes: set[str] = set()
        self._bar: Any = None
        self._task: Any = None

    @property
    def names_failures(self) -> bool:
        """Whether views that fail are told of as they come."""
        return self._kind != "none" and not (self._kind == "bar" and self._bar is None)

    def begin(self, total: int, before: int) -> None:
        """Tell how many views there are, and how many were there before."""
        self._started = self._said = time.monotonic()
        if self._kind == "json":
            _write({"event": "begin", "views": total, "before": before})
        elif self._kind == "bar" and total > before:
            self._bar = _bar()
            self._task = self._bar.add_task("views", total=total - before, rate="")
            self._bar.start()
        elif self._kind == "lines" and total > before:
            _line(f"{total} views" + (f", {before} from before" if before else ""))

    def track(self, row: Row, done: int, total: int) -> None:
        """Tell of a view that was drawn, or could not be; the ``done``-th of ``total``."""
        now = time.monotonic()
        rate = done / max(now - self._started, 1e-6)
        left = (total - done) / rate if rate else None
        failed = self._new_cause(row)
        if self._kind == "json":
            _write(_event(row, done, total, rate, left))
        elif self._kind == "bar":
            if self._bar is not None:
                self._bar.update(self._task, completed=done, rate=f"{rate:.1f}/s")
                if failed:
                    self._bar.console.print(failed, markup=False, highlight=False)
        elif self._kind == "lines" and (now - self._said > EVERY or failed):
            self._said = now
            remaining = "" if left is None else f", {_clock(left)} left"
            _line(f"{done} of {total} views, {rate:.1f}/s{remaining}{'; ' if failed else ''}{failed}")

    def _new_cause(self, row: Row) -> str:
        """Return what is said of a view that failed; nothing when as much was said of another, or of many others."""
        error = row.get("error", "")
        if not error or error in self._causes or len(self._causes) == MOST_CAUSES:
            return ""
        self._causes.add(error)
        return f"failed: {row['name']}: {error}"

    def end(self, results: Results) -> None:
        """Tell how it ended."""
        if self._kind == "json":
            counts = {"drawn": results.drawn, "before": results.before, "failed": len(results.failed)}
            _write({"event": "end", **counts, "seconds": round(results.seconds, 3)})

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()


def _event(row: Row, done: int, total: int, rate: float, left: float | None) -> dict[str, Any]:
    facts = {"name": row["name"], "done": done, "of": total, "rate": round(rate, 3), "remaining_s": left and round(left, 1)}
    if "error" in row:
        return {"event": "failed", **facts, "error": row["error"]}
    return {"event": "view", **facts, **{key: row[key] for key in ("seconds", "coverage", "warnings", "worker")}}


def _bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    rate = TextColumn("{task.fields[rate]}")
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), rate, TimeRemainingColumn())
    return Bar(*columns, console=Console(stderr=True))


def _write(event: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(event) + "\n")
    sys.stdout.flush()


def _line(text: str) -> None:
    sys.stderr.write(f"ssao-gl: {''.join(c if c.isprintable() else '?' for c in text)}\n")
    sys.stderr.flush()


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
