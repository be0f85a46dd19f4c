"""Names of what a picture can hold."""

from __future__ import annotations

from typing import Any

import pytest

import ssao_gl as ao
from ssao_gl.pipeline.outputs import aov_names


@pytest.mark.parametrize("given", ["depth,normal", " depth , normal,depth", ("depth", "normal"), ["depth", "normal"]])
def test_names(given: Any) -> None:
    assert aov_names(given) == ("depth", "normal")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("", "name at least one"),
        ((), "name at least one"),
        ("dept", "Did you mean 'depth'?"),
        (3, "must be names"),
        ((1,), "must be names"),
    ],
)
def test_no_names(given: Any, words: str) -> None:
    with pytest.raises(ao.SettingsError, match=words.replace("?", r"\?")):
        aov_names(given)
