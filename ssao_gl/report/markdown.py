"""The report as Markdown: the plots by name, and every table."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from .columns import Table, text
from .facts import facts
from .plots import Plot
from .tables import tables


def markdown(found: Mapping[str, Any], drawn: Sequence[Plot]) -> str:
    """Return the whole text."""
    parts = ["# Ambient occlusion: error against time", _code(found["command"])]
    parts += [f"![{plot.title}]({plot.name}.svg)" for plot in drawn]
    parts += [f"## {table.title}\n\n{table.note}\n\n{grid(table)}" for table in tables(found)]
    parts.append("## Made with\n\n" + "\n".join(f"- {name}: {_plain(value)}" for name, value in facts(found).items()))
    return "\n\n".join(parts) + "\n"


def grid(table: Table) -> str:
    """Return a table of GitHub's Markdown; numbers to the right."""
    number = [bool(column.spec) for column in table.columns]
    lines = [
        "| " + " | ".join(_plain(column.title) for column in table.columns) + " |",
        "|" + "|".join("---:" if right else "---" for right in number) + "|",
    ]
    for row in table.rows:
        cells = [_plain(text(cell, column.spec)) for cell, column in zip(row, table.columns, strict=True)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _plain(words: str) -> str:
    """Return words on one line, fit for a cell and a list: nothing in them is markup."""
    line = escape(" ".join(words.split()), quote=False)
    return re.sub(r"([\\|`*_~\[\]])", r"\\\1", line)


def _code(words: str) -> str:
    """Return words as code on one line, between more backticks than are in them (CommonMark 0.31, section 6.1)."""
    line = " ".join(words.split())
    fence = "`" * (1 + max(map(len, re.findall("`+", line)), default=0))
    return f"{fence} {line} {fence}" if "`" in line else f"{fence}{line}{fence}"
