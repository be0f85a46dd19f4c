"""Shader texts without what no compiler needs: comments, spaces, and branches that no define can reach."""

from __future__ import annotations

import re
from collections.abc import Collection

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_DIRECTIVE = re.compile(r"#\s*(if|ifdef|ifndef|elif|else|endif)\b\s*(\w*)")
_NAMED = re.compile(r"#\s*define\s+(\w+)")
_SPACE = re.compile(r" *([*/=<>!?:;,(){}&|^%]) *|(?<![-+]) ([-+]) (?![-+])")
"""Around what is no letter or digit; signs that meet stay apart."""

NEXT = {
    "elif": {"open": "open", "taken": "done", "skipped": "open", "done": "done"},
    "else": {"open": "open", "taken": "done", "skipped": "taken", "done": "done"},
}
"""Directive -> state of a condition before and after it. open: nothing is decided; taken, skipped, done: in the branch that is
taken, before it, after it."""


def compact(text: str, maybe: Collection[str] = (), always: Collection[str] = ()) -> str:
    """Return a shader text without comments, empty lines and idle spaces, and with the branches alone that can be reached.

    maybe: names that may be defined when it is compiled, always: that will be; no other will be but those that it defines itself.
    """
    lines = [line.strip() for line in _COMMENT.sub("", text).splitlines()]
    open_names = {*maybe, *_NAMED.findall(text)} - {*always}
    kept = _reachable([line for line in lines if line], open_names, always)
    return "\n".join(line if line.startswith("#") else _SPACE.sub(r"\1\2", line) for line in kept) + "\n"


def _reachable(lines: list[str], maybe: Collection[str], always: Collection[str]) -> list[str]:
    """Decide ``#ifdef`` and ``#ifndef`` of names that are not ``maybe``; other conditions stay as they are."""
    kept: list[str] = []
    blocks: list[str] = []  # the state of each condition around a line
    for line in lines:
        directive, name = match.groups() if (match := _DIRECTIVE.match(line)) else ("", "")
        first = directive in ("if", "ifdef", "ifndef")
        state = _opened(directive, name, maybe, always) if first else blocks.pop() if directive else "open"
        seen = all(around in ("open", "taken") for around in blocks)
        if seen and state == "open":
            kept.append(line)
        elif seen and (directive, state) == ("elif", "skipped"):
            kept.append(line.replace("elif", "if", 1))
        if first:
            blocks.append(state)
        elif directive in ("elif", "else"):
            blocks.append(NEXT[directive][state])
    return kept


def _opened(directive: str, name: str, maybe: Collection[str], always: Collection[str]) -> str:
    """Return the state of a condition behind its first line."""
    if directive == "if" or name in maybe:
        return "open"
    return "taken" if (name in always) == (directive == "ifdef") else "skipped"
