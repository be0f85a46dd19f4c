"""Tests of ``stress/specimen.py``."""

from __future__ import annotations

import pytest

import ssao_gl as ao
from ssao_gl.stress.specimen import specimens


def test_unknown_presets_and_methods() -> None:
    with pytest.raises(ao.SettingsError, match="no method has it"):
        specimens(presets=["hihg"])
    with pytest.raises(ao.SettingsError, match="Did you mean 'alchemy'"):
        specimens(["alchemi"])
    assert len(specimens(presets=["all"])) > len(specimens())
