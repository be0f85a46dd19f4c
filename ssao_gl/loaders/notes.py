"""What a reader dropped, guessed or converted: collected, so that each is said once."""

from __future__ import annotations

import logging

from ..errors import one_line

LOG = logging.getLogger("ssao_gl")


class Notes:
    """A list of lines without repetition."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}

    def add(self, text: str) -> None:
        """Keep a line, cut to a sane length."""
        self._lines[one_line(text)] = None

    @property
    def lines(self) -> tuple[str, ...]:
        """All of them, in order."""
        return tuple(self._lines)

    def say(self, where: object) -> None:
        """Log every line as a warning about ``where``."""
        for line in self._lines:
            LOG.warning("%s: %s", one_line(where), line)
