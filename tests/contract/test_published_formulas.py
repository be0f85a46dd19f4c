"""The published formulas of the comparators, against integrals computed here from the geometry alone.

All look straight down into the corner of two walls, by a parallel projection: at ``x`` the walls rise ``|x|`` to the viewer.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import ssao_gl as ao
from ssao_gl.scene.camera import Camera

from ..shapes import camera, corner, plane

Array = NDArray[np.float64]

COMPARATORS = ("crytek", "gtao", "hbao", "sao", "starcraft2", "volumetric")
RADIUS = 0.8
PIXELS = 60  # a scene unit
SIZE = (320, 240)
COLUMNS = np.arange(48, 320 - 48, 12)
"""First columns of tiles, from which the radius stays in the image."""


def render(renderer: ao.Renderer, name: str, *, blur: Any = None, scene: Any = None, **settings: Any) -> Array:
    method = dataclasses.replace(ao.method(name), **{"radius": RADIUS, **settings})
    parallel = Camera.orthographic(SIZE[1] / PIXELS, 0.0, 40.0)
    made = ao.Settings(method=method, blur=blur)
    picture = renderer.render(scene or corner(), parallel, SIZE, made, aovs=("visibility",), checked=True)
    return picture.visibility.astype(np.float64)


def profile(renderer: ao.Renderer, name: str, **settings: Any) -> Array:
    """Visibility averaged over rows and the four columns of a tile, and so over the noise."""
    rows = render(renderer, name, **settings)[60:180].mean(0)
    return np.array([rows[c : c + 4].mean() for c in COLUMNS])


def expected(formula: Callable[[float], float]) -> Array:
    """What :func:`profile` should be."""
    places = (COLUMNS[:, None] + np.arange(4) + 0.5 - SIZE[0] / 2) / PIXELS
    return np.vectorize(formula)(places).mean(1)


def rise(place: float, x: Array) -> Array:
    """How far the walls rise above the surface at ``place``, in radii, at x radii from there."""
    return np.abs(place / RADIUS + x) - abs(place) / RADIUS


def normal(place: float) -> Array:
    return np.array([-np.sign(place), 0, 1]) / np.sqrt(2)


def ball() -> Array:
    """(n, 3) midpoints of a grid over the unit ball."""
    axis = (np.arange(60) + 0.5) / 30 - 1
    points = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
    return points[(points**2).sum(1) < 1]


BALL = ball()


def crytek(place: float) -> float:
    return float((rise(place, BALL[:, 0]) <= BALL[:, 2]).mean())


def hemisphere(place: float) -> Array:
    return BALL[BALL @ normal(place) > 0]


def volumetric(place: float) -> float:
    points = hemisphere(place)
    return float((rise(place, points[:, 0]) <= points[:, 2]).mean())


def starcraft2(place: float) -> float:
    points = hemisphere(place)
    before = rise(place, points[:, 0]) - points[:, 2]
    return 1 - float(np.where(before > 0, 1 - np.clip((before - 0.25) / 1.25, 0, 1) ** 2, 0).mean())


def polar(turns: int, lengths: int) -> tuple[Array, Array]:
    """Angles (turns, 1) and lengths (1, lengths), midpoints."""
    angle = (np.arange(turns)[:, None] + 0.5) * 2 * np.pi / turns
    return angle, (np.arange(lengths)[None] + 0.5) / lengths


def sao(place: float) -> float:
    """Taps are dense as 1 / length on the spiral, that is even in length."""
    angle, length = polar(120, 1500)
    x, y = length * np.cos(angle), length * np.sin(angle)
    v = np.stack([x, y, rise(place, x)], -1)
    vv = (v**2).sum(-1)
    terms = np.maximum(1 - vv, 0) ** 3 * np.maximum(v @ normal(place) - 0.01, 0) / (vv + 0.01)
    return max(0.0, 1 - 5 * float(terms.mean()))


def hbao(place: float) -> float:
    angle, length = polar(120, 1500)
    high = rise(place, length * np.cos(angle))
    d2 = length**2 + high**2
    sine = high / np.sqrt(d2)
    start = np.sin(np.arctan(np.sign(place) * np.cos(angle)) + 0.1)
    horizon = np.maximum.accumulate(np.where(d2 < 1, np.maximum(sine, start), -1), 1)
    steps = np.diff(horizon, axis=1, prepend=start)
    return 1 - float((np.maximum(1 - d2, 0) * np.maximum(steps, 0)).sum(1).mean())


def gtao(place: float) -> float:
    """The closed form of a wall within a hard radius."""
    k = min(abs(place) * np.sqrt(2) / RADIUS, 1)
    return float(1 - (np.arccos(k) - k * np.sqrt(1 - k**2)) / np.pi)


FORMULAS: dict[str, tuple[Callable[[float], float], dict[str, Any]]] = {
    "crytek": (crytek, {"samples": 128}),
    "gtao": (gtao, {"slices": 8, "steps": 24, "radius_multiplier": 1.0, "falloff": 0.001, "lift": 0.0, "power": 1.0}),
    "hbao": (hbao, {"directions": 12, "steps": 24, "bias": 0.1}),
    "sao": (sao, {"samples": 63, "turns": 25}),
    "starcraft2": (starcraft2, {"samples": 64, "radii": 1, "full": 0.25, "none": 1.5, "power": 2.0}),
    "volumetric": (volumetric, {"pairs": 32}),
}


COUNTS = {"samples", "turns", "slices", "steps", "directions", "pairs"}


@pytest.mark.parametrize("name", COMPARATORS)
def test_many_samples_reach_the_published_integral(any_renderer: ao.Renderer, name: str) -> None:
    formula, settings = FORMULAS[name]
    published = expected(formula)
    assert np.ptp(published) > 0.2
    np.testing.assert_allclose(profile(any_renderer, name, **settings), published, atol=0.02)


@pytest.mark.parametrize("name", COMPARATORS)
def test_few_samples_as_shipped_scatter_about_many(any_renderer: ao.Renderer, name: str) -> None:
    """Averaged over the tile, that is; few taps miss some of what horizons rise to."""
    changes = {key: value for key, value in FORMULAS[name][1].items() if key not in COUNTS}
    few = profile(any_renderer, name, **changes)
    assert np.sqrt(np.mean((few - expected(FORMULAS[name][0])) ** 2)) < 0.05


@pytest.mark.parametrize("name", COMPARATORS)
def test_a_clamped_radius_is_a_smaller_radius(any_renderer: ao.Renderer, name: str) -> None:
    multiplier = getattr(ao.method(name), "radius_multiplier", 1.0)
    clamped = render(any_renderer, name, max_radius=24.0)
    small = render(any_renderer, name, radius=24.0 / PIXELS / multiplier)
    assert (np.abs(clamped - small) > 1.5 / 255).mean() < 0.005  # a tap on the edge of a texel may round to the next
    assert np.abs(clamped - render(any_renderer, name)).max() > 0.1


@pytest.mark.filterwarnings("ignore::ssao_gl.InputWarning")
@pytest.mark.parametrize("name", COMPARATORS)
def test_any_numbers_give_visibility(any_renderer: ao.Renderer, name: str) -> None:
    """Depth and normals as no renderer would leave them; nothing may be undefined, and background stays open."""
    rng = np.random.default_rng(7)
    odd = np.array([0, -1, np.nan, np.inf, -np.inf, 1e-38, 1e-10, 1e-3, 1, 1.0001, 5, 1e6, 1e20, 3e38], np.float32)
    depth = rng.choice(odd, (48, 64)).astype(np.float32)
    normals = rng.choice(np.array([0, 1, -1, 1e-20, 3e38, np.nan, np.inf], np.float32), (48, 64, 3))
    for radius in (1e-6, 1.0, 1e6):
        settings = ao.Settings(method=dataclasses.replace(ao.method(name), radius=radius), blur=None)
        for lens in (camera(), Camera.orthographic(4.0, 0.0, 40.0)):
            for given in (None, normals):
                seen = any_renderer.apply(
                    depth, lens, color=None, normals=given, depth_kind="eye", settings=settings
                ).visibility
                assert np.isfinite(seen).all() and seen.min() >= 0 and seen.max() <= 1
                assert (seen[~(np.isfinite(depth) & (depth > 0))] == 1).all()


def test_starcraft2_takes_the_largest_occlusion_of_its_radii(any_renderer: ao.Renderer, embedded: ao.Scene) -> None:
    def shot(**settings: Any) -> Array:
        made = ao.Settings(method=dataclasses.replace(ao.method("starcraft2"), **settings), blur=None)
        return any_renderer.render(embedded, None, SIZE, made, aovs=("visibility",)).visibility.astype(np.float64)

    singles = [shot(radius=RADIUS * share, radii=1) for share in (1, 0.5, 0.25)]
    assert all((one < other - 0.1).any() for one in singles for other in singles if one is not other)
    np.testing.assert_array_equal(shot(radius=RADIUS, radii=3, ratio=0.5), np.min(singles, 0))


def test_crytek_greys_a_plane_and_doubled_opens_it(any_renderer: ao.Renderer) -> None:
    once = render(any_renderer, "crytek", scene=plane(0.3))[60:180, 60:260]
    twice = render(any_renderer, "crytek", scene=plane(0.3), doubled=True)[60:180, 60:260]
    assert once.mean() == pytest.approx(0.5, abs=0.02) and once.std() < 0.06
    np.testing.assert_allclose(twice, np.minimum(1, 2 * once), atol=1.6 / 255)


def test_gtao_reaches_the_exhaustive_reference_of_infinite_thickness(any_renderer: ao.Renderer, embedded: ao.Scene) -> None:
    """On a scene with edges, thin parts and background."""
    settings = {**FORMULAS["gtao"][1], "radius": 0.5}
    truth = dataclasses.replace(ao.method("reference"), radius=0.5, thickness=None, slices=16)
    shots = [
        any_renderer.render(embedded, None, (160, 120), ao.Settings(method=made, blur=None), aovs=("visibility",)).visibility
        for made in (dataclasses.replace(ao.method("gtao"), **settings), truth)
    ]
    assert shots[1].std() > 0.1
    assert np.sqrt(np.mean((shots[0].astype(np.float64) - shots[1]) ** 2)) < 0.03


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("gtao", {"thin": 0.7}),
        ("gtao", {"lift": 1.0}),
        ("gtao", {"power": 1.0}),
        ("gtao", {"falloff": 1.0}),
        ("hbao", {"bias": 0.5}),
        ("hbao", {"intensity": 0.5}),
        ("sao", {"bias": 0.2}),
        ("sao", {"intensity": 0.5}),
        ("starcraft2", {"full": 0.1}),
        ("starcraft2", {"full": 0.1, "none": 1.1}),
    ],
    ids=str,
)
def test_settings_that_lighten(any_renderer: ao.Renderer, name: str, change: dict[str, float]) -> None:
    shipped, lighter = render(any_renderer, name), render(any_renderer, name, **change)
    assert (lighter >= shipped - 1.5 / 255).all() and lighter.mean() > shipped.mean() + 0.002
