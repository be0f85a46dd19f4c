"""Compacted shader texts: the same tokens, without what no define can reach."""

from __future__ import annotations

import pytest

from ssao_gl.glsl.compact import compact

TEXT = """\
// a comment
#ifdef ON
    a = b - -c;  /* two
    lines */
#ifdef OPEN
    d(1.0, 2.0);
#else
    e;
#endif
#else
    f;
#endif
#ifndef OFF
    g;
#else
#if OFF == 1
    h;
#endif
#endif
#define SELF
#ifdef SELF
    i++ + ++j;
#endif
"""


@pytest.mark.parametrize(
    ("always", "kept"),
    [
        (("ON",), "a=b - -c;\n#ifdef OPEN\nd(1.0,2.0);\n#else\ne;\n#endif\ng;\n"),
        ((), "f;\ng;\n"),
        (("OFF",), "f;\n#if OFF == 1\nh;\n#endif\n"),
    ],
)
def test_branches_that_are_decided_go(always: tuple[str, ...], kept: str) -> None:
    assert compact(TEXT, ("OPEN",), always) == kept + "#define SELF\n#ifdef SELF\ni++ + ++j;\n#endif\n"


def test_names_that_may_be_defined_stay_open() -> None:
    text = "#ifndef OPEN\nx;\n#elif OTHER\ny;\n#endif\n"
    assert compact(text, ("OPEN",)) == text


CHAIN = "#ifdef ON\na;\n#elif defined(OPEN)\nb;\n#elif defined(OTHER)\nc;\n#else\nd;\n#endif\n"


def test_chains_end_with_the_branch_that_is_taken() -> None:
    assert compact(CHAIN, ("OPEN", "OTHER"), ("ON",)) == "a;\n"


def test_a_chain_begins_with_the_first_branch_that_is_open() -> None:
    rest = CHAIN.split("a;\n", 1)[1].replace("#elif", "#if", 1)
    assert compact(CHAIN, ("OPEN", "OTHER")) == rest
