"""Spellings of numbers on the command line."""

from __future__ import annotations

import pytest

from ssao_gl.cli.tokens import joined_numbers, parse_share


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("--eye 1 2 3 a.glb", "--eye 1,2,3 a.glb"),
        ("--eye -1 -2.5 -3e-2 --up 0 0 1", "--eye -1,-2.5,-3e-2 --up 0,0,1"),
        ("a.glb --size 640 480", "a.glb --size 640x480"),
        ("--intrinsics 525 525 319.5 239.5", "--intrinsics 525,525,319.5,239.5"),
    ],
)
def test_numbers_of_an_option_are_one_word(words: str, found: str) -> None:
    assert joined_numbers(words.split()) == found.split()


@pytest.mark.parametrize(
    "words",
    ["--eye 1,2,3 4 5 6", "--eye 1 2", "--eye 1 2 a.glb", "--eye nan 1 2", "--size 640x480 3 4", "1 2 3", "--up z", "--eye"],
)
def test_other_words_stay_as_they_are(words: str) -> None:
    assert joined_numbers(words.split()) == words.split()


@pytest.mark.parametrize(("text", "share"), [("10%", 0.1), ("2.5%", 0.025), ("150%", 1.5)])
def test_shares(text: str, share: float) -> None:
    assert parse_share(text) == pytest.approx(share)


@pytest.mark.parametrize("text", ["", "%", "10", "0%", "-1%", "nan%", "inf%", "a%", "10%%"])
def test_no_shares(text: str) -> None:
    assert parse_share(text) is None
