"""Words of the command line in other spellings that can mean one thing only."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from cyclopts import Parameter, Token

from ..errors import SettingsError

LISTS: Mapping[str, tuple[int, str]] = {
    "--size": (2, "x"),
    "--eye": (3, ","),
    "--target": (3, ","),
    "--up": (3, ","),
    "--intrinsics": (4, ","),
    "--light": (2, ","),
}
"""Option -> how many numbers it takes, and what stands between them."""


def joined_numbers(words: Sequence[str]) -> list[str]:
    """Return the words with the numbers of an option in one word: ``--eye 1 2 3`` is ``--eye 1,2,3``."""
    found: list[str] = []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        found.append(word)
        count, between = LISTS.get(word, (0, ""))
        numbers = rest[:count]
        if count and len(numbers) == count and all(map(is_number, numbers)):
            found.append(between.join(numbers))
            del rest[:count]
    return found


def whole_number(kind: object, tokens: Sequence[Token]) -> int:
    """Return the number of an option; whole floats are taken, others are not rounded. Raises SettingsError."""
    option, text = tokens[0].keyword or "", tokens[0].value
    try:
        number = int(text) if re.fullmatch("[+-]?[0-9]+", text) else float(text)
        if number == int(number):
            return int(number)
    except (ValueError, OverflowError):
        pass
    raise SettingsError(f"{option} {text[:40]}: must be a whole number".strip())


WHOLE = Parameter(converter=whole_number)
"""Beside the type of an option that is a whole number."""


def is_number(text: str) -> bool:
    """Whether a word is one finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def parse_share(text: str) -> float | None:
    """Return ``10%`` as 0.1; None for what is no percentage above 0."""
    number = text.removesuffix("%")
    return float(number) / 100 if number != text and is_number(number) and float(number) > 0 else None
