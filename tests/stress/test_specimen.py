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


def test_a_method_that_shows_what_a_scene_keeps_is_refused() -> None:
    with pytest.raises(ao.SettingsError, match="--methods baked: shows what a scene keeps"):
        specimens(["baked"])


def test_a_method_that_makes_what_it_needs_is_not() -> None:
    (one,) = specimens(["field"])
    assert one.name == "field" and one.method.traits.needs_scene
