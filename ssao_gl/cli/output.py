"""What commands print: plain lines on standard output, a progress bar only on a terminal."""

from __future__ import annotations

import json
import logging
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from ..errors import FormatError, InputWarning, SettingsError, near_miss, one_line
from ..io.atomic import atomic_write, check_writable, is_folder, why_unreadable
from ..io.cache import default_folder
from ..io.streams import STDOUT, is_stream, output_suffix
from ..scene.projection import MAX_SIDE, pixel_size
from .tokens import parse_share

Item = TypeVar("Item")
QUIET: ContextVar[bool] = ContextVar("quiet", default=False)
TAKEN: ContextVar[str] = ContextVar("taken", default="")
"""The option whose output goes to standard output."""


@contextmanager
def input_warnings(*, strict: bool) -> Iterator[list[str]]:
    """Say each :class:`InputWarning` of the block once on standard error, and yield the list of them.

    Raises FormatError for the first one when ``strict``.
    """
    told: list[str] = []
    before = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *more: Any, **named: Any) -> None:
        if not issubclass(category, InputWarning):
            before(message, category, *more, **named)
        elif (text := one_line(message)) not in told:
            told.append(text)
            if not QUIET.get():
                sys.stderr.write(f"ssao-gl: warning: {text}\n")

    with warnings.catch_warnings():
        warnings.simplefilter("error" if strict else "always", InputWarning)
        warnings.showwarning = show
        try:
            yield told
        except InputWarning as warning:
            raise FormatError(f"{one_line(warning)} (--strict)") from None


def say(text: str) -> None:
    """Write a line to standard output, unless ``--quiet``; to standard error when an output goes there."""
    if not QUIET.get():
        (sys.stderr if TAKEN.get() else sys.stdout).write(text + "\n")


def _take(option: str, path: Path) -> None:
    """Note that an output goes to standard output. Raises SettingsError when another one does, or for another option."""
    if path != STDOUT and str(path).startswith("-"):  # after a forgotten file name
        raise SettingsError(f"{option} {path}: must be a file name, or - for standard output")
    if path == STDOUT:
        if TAKEN.get():
            raise SettingsError(f"{TAKEN.get()} and {option}: only one of them can go to standard output")
        TAKEN.set(option)


def print_table(title: str, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Print a table as wide as the terminal (as wide as it needs when piped)."""
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


@contextmanager
def counted(title: str) -> Iterator[Callable[[int, int], None] | None]:
    """Show a progress bar with the time left, when standard error is a terminal; it is told (done, total), at any time."""
    if QUIET.get() or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def write_json(path: Path, content: Mapping[str, Any] | Sequence[Any]) -> None:
    """Write a report, whole or not at all; ``-`` is standard output."""
    write_text(path, json.dumps(content, indent=1) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a text, whole or not at all; ``-`` is standard output."""
    if path == STDOUT:
        sys.stdout.write(text)
        return
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")


def check_output(option: str, path: Path, suffixes: Sequence[str], *, folder: bool = False) -> None:
    """Raise FormatError, before any work is done, when ``path`` cannot be written or has a suffix that is not known."""
    known = ", ".join(suffixes) + (", or a folder" if folder else "")
    _take(option, path)
    if is_stream(path) and not path.suffix and output_suffix(path) in suffixes:
        check_writable(path)
    elif folder and is_folder(path):
        check_writable(path, folder=True)
    elif path.suffix.lower() in suffixes:
        check_writable(path)
    elif path.suffix or not folder:
        raise FormatError(f"{option} {path}: unknown suffix '{path.suffix}'; use {known}.{near_miss(path.suffix, suffixes)}")
    elif why_unreadable(path, empty=True) is None:
        raise FormatError(f"{option} {path}: is a file; use a name that ends in {known}")
    else:
        check_writable(path, folder=True)


def check_json(path: Path | None) -> None:
    """Raise FormatError, before any work is done, when a report cannot be written."""
    if path is not None:
        _take("--json", path)
        if path != STDOUT:
            check_writable(path)


def comma_list(texts: Iterable[str]) -> list[str]:
    """Return the words of texts that hold several, by commas."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def parse_size(text: str, option: str = "--size") -> tuple[int, int]:
    """``1280x720`` -> (1280, 720), sides within bounds; whole floats are taken, too. Raises SettingsError."""
    found = re.fullmatch(r"([0-9]+)(?:\.0*)?[xX]([0-9]+)(?:\.0*)?", text)
    if not found:
        raise SettingsError(f"{option} {text}: must be WIDTHxHEIGHT in whole pixels, like 1280x720")
    try:
        return pixel_size([int(side[:9]) for side in found.groups()])
    except SettingsError:
        raise SettingsError(f"{option} {text}: must be WIDTHxHEIGHT with sides from 1 to {MAX_SIDE}, like 1280x720") from None


def check_radius(text: str) -> str:
    """Return a radius as it is when it is a number. Raises SettingsError."""
    try:
        float(text)
    except ValueError:
        raise SettingsError(
            f"--radius {text}: must be a number of scene units, or a share of the scene's size above 0, like 10%"
        ) from None
    return text


def own_length(radius: str | None) -> float | None:
    """Return a radius in scene units; None for one that is a share of the scene, or not given. Raises SettingsError."""
    return None if radius is None or parse_share(radius) is not None else float(check_radius(radius))


def parse_vector(name: str, text: str) -> tuple[float, float, float]:
    """``1,2,3`` -> (1.0, 2.0, 3.0). Raises SettingsError."""
    parts = text.split(",")
    try:
        x, y, z = (float(part) for part in parts)
    except ValueError:
        axis = ", or an axis: x, y or z" if name == "up" else ""
        raise SettingsError(f"--{name} {text}: must be three numbers, like 1,2.5,-3{axis}") from None
    return x, y, z


def cache_folder(given: Path | None) -> Path | None:
    """Return the cache folder; one that was not asked for and cannot be written is done without. Raises FormatError."""
    folder = given or default_folder()
    try:
        check_writable(folder, folder=True)
    except FormatError as error:
        if given is not None:
            raise
        logging.getLogger("ssao_gl").warning("%s; going on without a cache", error)
        return None
    return folder
