"""``lib/slice.glsl`` against integrals of the slice's measure, and against what it says of surfaces that face away."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import ssao_gl as ao
from ssao_gl.gl.executor import FrameExecutor
from ssao_gl.gl.programs import GpuResources
from ssao_gl.graph.declare import Pass, Texture
from ssao_gl.graph.draws import Fullscreen
from ssao_gl.graph.frame_graph import compile

from ..shapes import camera

SIZE = (128, 64)
SHADER = f"{__name__.rpartition('.')[0]}.shaders:slices.frag"
NAMES = ("weight", "u0", "lower", "upper")
GAMMA = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2 * np.pi - np.pi
T = (np.arange(SIZE[1]) + 0.5) / SIZE[1] * np.pi
Array = NDArray[np.float64]


def slices(provider: str, out: float) -> dict[str, Array]:
    """weight, u0 and u of both sides, (64, 128): by the angle from the viewer, and by that of the normal."""
    with ao.gl.open(provider) as ctx:
        resources = GpuResources(ctx)
        draw = Fullscreen(SHADER, uniforms={"u_out": out}, defines={"TARGETS": 4})
        plan = compile([Pass("slices", "prepare", draw, {name: Texture("r32f") for name in NAMES})], SIZE, NAMES)
        executor = FrameExecutor(resources, plan)
        frame = executor.run(camera().view(SIZE), checked=True)
        found = {name: frame.read(name).reshape(SIZE[::-1]).astype(np.float64) for name in NAMES}
    return found


def measure(gamma: float, low: float, high: float) -> float:
    """``cos(t - gamma) |sin t|`` over ``low..high``, by the middles of 4000 steps."""
    t = low + (np.arange(4000) + 0.5) / 4000 * (high - low)
    return float((np.cos(t - gamma) * np.abs(np.sin(t))).mean() * (high - low))


@pytest.mark.parametrize("out", [0.0, 0.6])
def test_a_slice_is_its_integral(provider: str, out: float) -> None:
    """Of surfaces that face the viewer: the weight is all of the measure over the hemisphere, u the share below an angle."""
    seen = slices(provider, out)
    for column in np.flatnonzero(np.abs(GAMMA) < np.pi / 2)[::5]:
        gamma = GAMMA[column]
        low, high = gamma - np.pi / 2, gamma + np.pi / 2
        whole = measure(gamma, low, high)
        assert seen["weight"][0, column] == pytest.approx(np.sqrt(1 - out**2) * whole, abs=1e-3)
        assert seen["u0"][0, column] == pytest.approx(measure(gamma, low, 0) / whole, abs=1e-3)
        for row in range(0, SIZE[1], 5):
            upper = measure(gamma, low, min(T[row], high)) / whole
            lower = measure(gamma, low, max(-T[row], low)) / whole
            assert seen["upper"][row, column] == pytest.approx(upper, abs=2e-3)
            assert seen["lower"][row, column] == pytest.approx(lower, abs=2e-3)


@pytest.mark.parametrize("out", [0.0, 0.6])
def test_a_surface_that_faces_away_is_taken_edge_on(provider: str, out: float) -> None:
    """Its hemisphere begins at the viewer, and it weighs no more the farther it turns away; every u stays a share."""
    seen = slices(provider, out)
    away = np.abs(GAMMA) > np.pi / 2
    edge = np.where(GAMMA > 0, 0.0, 1.0)[away]
    np.testing.assert_allclose(seen["u0"][0, away], edge, atol=1e-5)
    expected = np.sqrt(1 - out**2) * np.pi / 2 * np.abs(np.sin(GAMMA[away]))
    np.testing.assert_allclose(seen["weight"][0, away], expected, atol=1e-3)
    for side in ("lower", "upper"):
        assert seen[side].min() >= 0 and seen[side].max() <= 1
