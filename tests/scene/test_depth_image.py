"""One depth image in every form that files and sensors give it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ssao_gl as ao
from ssao_gl.stress.analytic_depth import ball_depth, cast, flat, window_depth

SIZE = (80, 60)
CAMERA = ao.Camera.pinhole(65, 65, 41, 29, SIZE, znear=0.1, zfar=10)
Z = cast(CAMERA, SIZE, flat((0, -0.5, 0), (0, 1, 0), within=4.0), ball_depth((0, -0.2, -2), 0.3)).astype(np.float32)
SEEN = Z > 0
FORMS: dict[str, tuple[Any, dict[str, Any]]] = {
    "eye": (Z, {}),
    "column": (Z[..., None], {}),
    "layer": (Z[None], {}),
    "inf": (np.where(SEEN, Z, np.inf), {}),
    "vtk": (-np.where(SEEN, Z, np.nan), {"kind": "vtk"}),
    "mask": (np.where(SEEN, Z, 1.5), {"mask": SEEN}),
    "masked array": (np.ma.masked_array(np.where(SEEN, Z, 1.5), ~SEEN), {}),
    "background": (np.where(SEEN, Z, -7.0), {"background": -7.0}),
    "centimetres": (100 * Z, {"scale": 0.01}),
    "window": (window_depth(CAMERA, Z, np.float64), {"kind": "window"}),
    "window of integers": (np.round(window_depth(CAMERA, Z, np.float64) * (2**32 - 1)).astype(np.uint32), {"kind": "window"}),
    "ray": (np.linalg.norm(CAMERA.view(SIZE).points(Z), axis=-1), {"kind": "ray"}),
    "saturated": (
        np.where(SEEN, np.round(Z * 65536.0).astype(np.float64), 2.0**32 - 1).astype(np.uint32),
        {"scale": 1 / 65536},
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_same(form: str) -> None:
    values, said = FORMS[form]
    found = ao.DepthImage(values, **said).linear(CAMERA)
    assert found.dtype == np.float32 and np.array_equal(found > 0, SEEN)
    assert np.abs(found - Z).max() <= 2e-5


def test_millimetres() -> None:
    found = ao.DepthImage(np.round(1000 * Z).astype(np.uint16), scale=0.001).linear(CAMERA)
    assert np.abs(found - Z).max() <= 5.1e-4
    with pytest.warns(ao.InputWarning, match="uint16 without a scale"):
        assert ao.DepthImage(np.round(1000 * Z).astype(np.uint16)).linear(CAMERA).max() > 1000


@pytest.mark.parametrize("far", [1e10, 65504.0, 1000.0, 3.5 * float(Z.max())])
def test_one_far_constant_is_background(far: float) -> None:
    with pytest.warns(ao.InputWarning, match="taken as background"):
        found = ao.DepthImage(np.where(SEEN, Z, far)).linear(CAMERA)
    assert np.array_equal(found, Z)
    kept = ao.DepthImage(np.where(SEEN, Z, far), background=np.nan).linear(CAMERA)
    assert (kept[~SEEN] == np.float32(far)).all()


def test_smoothed_edges_go_with_the_far_constant() -> None:
    values = np.where(SEEN, Z, 1e10)
    values[np.nonzero(~SEEN)[0][0], :5] = 3e9
    with pytest.warns(ao.InputWarning, match="taken as background"):
        assert np.array_equal(ao.DepthImage(values).linear(CAMERA), Z)


def test_no_surface_is_taken_for_background() -> None:
    """A wall at one distance; a floor and a ceiling whose last rows before the horizon are three times as far as the next."""
    level = ao.Camera.perspective(1.0)
    for surfaces in ([flat((0, 0, -5), (0, 0, 1))], [flat((0, -1, 0), (0, 1, 0)), flat((0, 1, 0), (0, 1, 0))]):
        z = cast(level, SIZE, *surfaces).astype(np.float32)
        assert np.array_equal(ao.DepthImage(z).linear(level), z)


BAD: dict[str, tuple[Any, dict[str, Any], str]] = {
    "negative": (-Z, {}, "depth is negative, as VTK and PyVista give it: depth kind 'vtk' reads it"),
    "positive": (Z, {"kind": "vtk"}, "depth is positive"),
    "zeros": (0 * Z, {}, "no usable texel: float32, 0 to 0, 0 nan of 4800"),
    "nan": (np.nan * Z, {}, "no usable texel: float32, no finite number, 4800 nan of 4800"),
    "far plane": (np.ones_like(Z), {"kind": "window"}, "no usable texel"),
    "distances": (Z + 2, {"kind": "window"}, "4800 of 4800 depths lie outside 0..1"),
    "masked": (Z, {"mask": 0 * Z}, "no usable texel"),
    "too far": (np.where(SEEN, 1e30, 0), {}, "no usable texel"),
    "shape": (np.ones(3), {}, r"float64 of shape \(3,\); expected numbers of shape \(h, w\)"),
    "colour": (np.ones((4, 4, 3)), {}, "expected numbers of shape"),
    "words": (np.full((4, 4), "a"), {}, "expected numbers of shape"),
    "other mask": (Z, {"mask": np.ones((3, 3))}, "depth mask of shape"),
    "too large": (np.broadcast_to(np.float32(1), (1, 1 << 17)), {}, "sides may have 65536"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_depth_is_refused(case: str) -> None:
    values, said, text = BAD[case]
    with pytest.raises(ao.FormatError, match=text):
        ao.DepthImage(values, **said).linear(CAMERA)


@pytest.mark.parametrize(
    "said", [{"kind": "eyes"}, {"scale": 0}, {"scale": np.nan}, {"noise": -1}, {"kind": "window", "scale": 2}], ids=str
)
def test_what_cannot_be_said(said: dict[str, Any]) -> None:
    with pytest.raises(ao.SettingsError):
        ao.DepthImage(Z, **said)


def test_few_wrong_values_are_told() -> None:
    wrong = Z.copy()
    wrong[SEEN & (np.arange(80) % 9 == 0)] *= -1
    with pytest.warns(ao.InputWarning, match="wrong sign for depth kind 'eye'"):
        assert np.array_equal(ao.DepthImage(wrong).linear(CAMERA), np.maximum(wrong, 0))
    window = window_depth(CAMERA, Z, np.float64)
    window[0, :3] = 1.5
    with pytest.warns(ao.InputWarning, match="3 of 4800 window depths lie outside"):
        ao.DepthImage(window, "window").linear(CAMERA)


@given(st.lists(st.floats(width=32), min_size=12, max_size=12), st.sampled_from(["eye", "window", "ray", "vtk"]))
@pytest.mark.filterwarnings("ignore::ssao_gl.InputWarning")
def test_any_bits_give_usable_depth_or_an_error(numbers: list[float], kind: str) -> None:
    try:
        found = ao.DepthImage(np.reshape(np.array(numbers, np.float32), (3, 4)), kind).linear(CAMERA)
    except ao.FormatError as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(found).all() and (found >= 0).all() and found.any()


def test_what_is_linear_as_it_stands_is_found_at_a_glance() -> None:
    """The same as by way of 64 bits, where every rule is tried; and a copy."""
    z = np.random.default_rng(4).uniform(1, 9, (12, 16)).astype(np.float32)
    z[2, 3:7] = 0
    quick, slow = ao.DepthImage(z).linear(CAMERA), ao.DepthImage(z.astype(np.float64)).linear(CAMERA)
    assert np.array_equal(quick, slow) and np.array_equal(quick, z) and not np.shares_memory(quick, z)
    z[4:8, 4:8] = 1e10
    with pytest.warns(ao.InputWarning, match=r"16 of 192 depths hold 1e\+10"):
        assert (ao.DepthImage(z).linear(CAMERA)[4:8, 4:8] == 0).all()
