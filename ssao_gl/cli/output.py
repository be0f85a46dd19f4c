"""What commands print: plain lines on standard output, a progress bar only on a terminal."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from ..errors import SettingsError
from ..files import written

Item = TypeVar("Item")
QUIET: ContextVar[bool] = ContextVar("quiet", default=False)


def say(text: str) -> None:
    """A line on standard output, unless ``--quiet``."""
    if not QUIET.get():
        sys.stdout.write(text + "\n")


def table(title: str, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """A table as wide as the terminal (as wide as it needs when piped)."""
    from rich.console import Console
    from rich.table import Table

    made = Table(title=title, title_justify="left", header_style="bold")
    for column in columns:
        made.add_column(column, overflow="fold")
    for row in rows:
        made.add_row(*row)
    console = Console(width=None if sys.stdout.isatty() else 160, markup=False, highlight=False)
    console.print(made)


def progress(items: Iterable[Item], title: str, total: int) -> Iterator[Item]:
    """``items`` with a progress bar and the time left, when standard error is a terminal."""
    if QUIET.get() or not sys.stderr.isatty() or total < 2:
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, title, total, console=Console(stderr=True))


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a report, whole or not at all; ``-`` is standard output."""
    text = json.dumps(content, indent=1) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
        return
    with written(path) as temporary:
        temporary.write_text(text, "utf-8")


def parse_size(text: str) -> tuple[int, int]:
    """``1280x720`` -> (1280, 720). Raises SettingsError."""
    w, x, h = text.lower().partition("x")
    if not (x and w.isascii() and h.isascii() and w.isdigit() and h.isdigit()):
        raise SettingsError(f"--size {text}: must be WIDTHxHEIGHT, like 1280x720")
    return int(w[:9]), int(h[:9])


def parse_vector(name: str, text: str) -> tuple[float, float, float]:
    """``1,2,3`` -> (1.0, 2.0, 3.0). Raises SettingsError."""
    parts = text.split(",")
    try:
        x, y, z = (float(part) for part in parts)
    except ValueError:
        raise SettingsError(f"--{name} {text}: must be three numbers, like 1,2.5,-3") from None
    return x, y, z
