"""Every error that ssao_gl raises on purpose.

::

    SsaoError            exit code of the command line: 2
    ├── ContextError     no usable OpenGL (3)
    ├── ShaderError      a shader text is missing, or the driver refused it
    ├── GraphError       a frame graph that cannot be compiled
    ├── FormatError      an array, picture or texture of the wrong shape, type or content
    ├── SettingsError    a parameter out of range, an unknown name
    └── SceneError       a scene, mesh or camera file that cannot be used

A message says what is wrong, where, what was expected and what to do, on one line where that fits.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from difflib import get_close_matches


class SsaoError(Exception):
    """Base of all; ``exit_code`` is what the command line ends with."""

    exit_code = 2

    def __init__(self, message: object = "") -> None:
        super().__init__(cut_words(str(message)))


class ContextError(SsaoError):
    """No OpenGL could be opened, or the one that was opened lacks something we cannot do without."""

    exit_code = 3


class ShaderError(SsaoError):
    """A shader could not be assembled, compiled or linked."""


class GraphError(SsaoError):
    """The frame graph is contradictory."""


class FormatError(SsaoError):
    """An array, picture or texture has the wrong shape, dtype or content."""


class SettingsError(SsaoError):
    """A setting is unknown or out of its range."""


class SceneError(SsaoError):
    """A scene or camera cannot be read or drawn."""


class InputWarning(UserWarning):
    """What was dropped, guessed or converted while an array, picture or camera was taken in.

    The command line says each once on standard error, lists them in ``--json``, and fails on one with ``--strict``; programs
    use Python's filters: ``warnings.simplefilter("error", InputWarning)``.
    """


def warn_of_input(text: str) -> None:
    """Give an :class:`InputWarning`."""
    warnings.warn(text, InputWarning, stacklevel=3)


def one_line(text: object, limit: int = 300) -> str:
    """Return what a file or a library says, fit for a message: one line, printable, at most ``limit`` characters."""
    line = "".join(c if c.isprintable() else "?" for c in " ".join(str(text).split()))
    return line if len(line) <= limit else line[: limit - 4] + " ..."


def cut_words(text: str, limit: int = 500) -> str:
    """Return a message with every word, such as a value or a path, cut in its middle to ``limit`` characters or less."""
    return re.sub(rf"\S{{{limit + 1},}}", lambda word: f"{word[0][: limit // 2]} ... {word[0][-limit // 4 :]}", text)


def encodable(text: str) -> str:
    """Return a text that any file takes: what is no character (half of a pair, a byte of a name) becomes its escape."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def near_miss(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """``" Did you mean 'x'?"`` when something like ``name`` is known, else ``""``."""
    plain = {word.casefold(): word for word in known}
    close = get_close_matches(name.casefold(), list(plain), 1, cutoff)
    return f" Did you mean '{plain[close[0]]}'?" if close else ""
