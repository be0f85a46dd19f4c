"""Words of the command line in other spellings that can mean one thing only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

LISTS: Mapping[str, tuple[int, str]] = {
    "--size": (2, "x"),
    "--eye": (3, ","),
    "--target": (3, ","),
    "--up": (3, ","),
    "--intrinsics": (4, ","),
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
