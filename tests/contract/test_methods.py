"""What every AO method promises, on every provider. A new method is tested here because it is registered."""

from __future__ import annotations

import pytest

import ssao_gl as ao
from ssao_gl.methods.base import Deviation
from ssao_gl.methods.registry import general
from ssao_gl.testing import CONTRACTS, check_method

from ..shapes import camera, corner


@pytest.mark.parametrize("contract", CONTRACTS)
@pytest.mark.parametrize("name", general())
def test_every_method_keeps_every_contract(renderer: ao.Renderer, name: str, contract: str) -> None:
    CONTRACTS[contract](renderer, name)


@pytest.mark.gl
@pytest.mark.parametrize(
    ("exceptions", "broken"),
    [
        ({}, {"a_plane_is_open", "no_radius_no_occlusion", "a_parallel_projection_is_like_any_other"}),
        ({"plane": 0.8, "radius": 0.6}, set()),
        ({"plane": 0.2, "radius": 0.6}, {"a_plane_is_open", "a_parallel_projection_is_like_any_other"}),
        ({"plane": 0.8, "radius": 0.6, "orthographic": float("inf")}, {"a_parallel_projection_is_like_any_other"}),
    ],
    ids=["nothing", "all", "too little", "a refusal"],
)
def test_a_method_that_breaks_a_contract_is_told_which(
    exceptions: dict[str, float], broken: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Crytek's, whose planes are grey by definition, with one declaration or another."""

    declared = {name: Deviation(bound, "half of the sphere lies behind a wall") for name, bound in exceptions.items()}
    monkeypatch.setattr(ao.registry()["crytek"], "exceptions", declared)
    try:
        check_method("crytek")
        told: list[str] = []
    except AssertionError as error:
        first, *told = str(error).splitlines()
        assert first.startswith(f"the AO method crytek breaks {len(broken)} of {len(CONTRACTS)} contracts")
    assert {line.partition(":")[0] for line in told} == broken


def test_a_name_that_nobody_registered_is_said() -> None:
    with pytest.raises(ao.SettingsError, match="unknown method 'glwo'"):
        check_method("glwo")


@pytest.mark.parametrize("max_radius", [256, 48])
def test_alchemy_is_calibrated_at_the_corner_of_two_walls(renderer: ao.Renderer, max_radius: float) -> None:
    """Seen along the bisector, a point in the corner is half occluded, also where the disk is clamped."""
    settings = ao.Settings(method=ao.Alchemy(radius=1.0, samples=64, bias=0.0, max_radius=max_radius))
    seen = renderer.render(corner(), camera(), (481, 360), settings, aovs=("visibility",)).visibility
    assert seen[150:210, 240].mean() == pytest.approx(0.5, abs=0.03)
