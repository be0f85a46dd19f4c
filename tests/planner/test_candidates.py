"""Tests of ``planner/candidates.py``."""

from __future__ import annotations

import pytest

import ssao_gl as ao
from ssao_gl.planner.candidates import CANDIDATES, FAMILIES, PROBES, chosen_from, differing
from ssao_gl.planner.plan import COARSE, DEEP, FINE


def test_every_preset_is_a_candidate() -> None:
    for method in PROBES:
        for name in ao.registry()[method].presets:  # type: ignore[attr-defined]
            made = CANDIDATES[f"{method} {name}"][1].made()
            assert made == ao.method(method, name)
    assert ao.Settings().method in [candidate.made() for _, candidate in CANDIDATES.values()], "and so is the default"


def test_what_the_planner_names_is_there() -> None:
    for one, two in PROBES.values():
        assert CANDIDATES[one][1].layers == 1 and two in CANDIDATES
    assert {FINE, COARSE, DEEP} <= set(CANDIDATES)
    assert len(CANDIDATES) == sum(len(family.values) for family in FAMILIES), "names are unique"
    assert len({family.name for family in FAMILIES}) == len(FAMILIES)


def test_arrays_have_one_layer() -> None:
    assert {c.layers for c in chosen_from([], 1)} == {1} and {c.layers for c in chosen_from([], 2)} == {1, 2}
    assert {c.method for c in chosen_from(["alchemy"], 2)} == {"alchemy"}
    with pytest.raises(ao.SettingsError, match=r"nothing is known of 'bitmsk' to plan by.*Did you mean 'bitmask'"):
        chosen_from(["bitmsk"], 2)


def test_what_would_be_overruled_is_named() -> None:
    assert differing(ao.Alchemy(radius=2.0)) == []
    assert differing(ao.Alchemy(radius=2.0, samples=5, bias=0.01)) == ["samples=5", "bias=0.01"]
