"""Tables for papers."""

from __future__ import annotations

from ssao_gl.report.latex import escaped, tabular
from ssao_gl.report.tables import Column, Table


def test_nothing_in_words_is_markup() -> None:
    assert escaped("a_b 5% & {c}\\ $x^2~# ×\n≤") == (
        r"a\_b 5\% \& \{c\}\textbackslash{} \$x\textasciicircum{}2\textasciitilde{}\# $\times$ $\le$"
    )


def test_numbers_to_the_right() -> None:
    table = Table("T", "N_1", (Column("name"), Column("× time", ".2f")), [["a&b", 1.234], ["c", None]])
    lines = tabular(table).splitlines()
    assert r"\begin{tabular}{lr}" in lines and r"\caption{T. N\_1}" in lines
    assert r"a\&b & 1.23 \\" in lines and r"c & -- \\" in lines and r"name & $\times$ time \\" in lines
