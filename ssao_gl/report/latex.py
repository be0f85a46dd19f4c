"""The report's tables for papers: LaTeX with booktabs, each in an environment of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .columns import Table, text
from .facts import facts
from .tables import tables

ESCAPES: Mapping[str, str] = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%", "_": r"\_",
    "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}",
    "×": r"$\times$", "≤": r"$\le$", "●": r"$\bullet$", "–": "--", "‘": "`", "’": "'",
}  # fmt: skip


def latex(found: Mapping[str, Any]) -> str:
    """Return every table of the results, to be read by ``\\input`` in a document that uses booktabs and graphicx."""
    head = [
        "% \\usepackage{booktabs,graphicx}",
        *(f"% {name}: {' '.join(value.split())}" for name, value in facts(found).items()),
    ]
    return "\n".join([*head, "", *(tabular(table) for table in tables(found))])


def tabular(table: Table) -> str:
    """Return one table, as wide as the text at most; numbers to the right."""
    align = "".join("r" if column.spec else "l" for column in table.columns)
    rows = [
        " & ".join(escaped(text(cell, column.spec)) for cell, column in zip(row, table.columns, strict=True)) + r" \\"
        for row in table.rows
    ]
    return "\n".join(
        [
            r"\begin{table}",
            rf"\caption{{{escaped(table.title)}. {escaped(table.note)}}}",
            r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
            rf"\begin{{tabular}}{{{align}}}",
            r"\toprule",
            " & ".join(escaped(column.title) for column in table.columns) + r" \\",
            r"\midrule",
            *rows,
            r"\bottomrule",
            r"\end{tabular}}",
            r"\end{table}",
            "",
        ]
    )


def escaped(words: str) -> str:
    """Return words in which nothing is markup, on one line."""
    return "".join(ESCAPES.get(c, c) for c in " ".join(words.split()))
