"""Bilateral filters of visibility. All leave background out and renormalise by the weights that remain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError, near_miss
from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Define, FloatTable, Fullscreen, Uniform, ViewValue
from ..graph.names import (
    BENT_NORMAL,
    GAINED,
    NORMAL,
    NORMAL_SMALL,
    VISIBILITY,
    VISIBILITY_BLUR_X,
    VISIBILITY_RAW,
    VISIBILITY_SMALL,
)  # fmt: skip
from ..settings import setting, validate
from .extra_signals import extra_signals


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterTraits:
    """What the pipeline may ask of a filter. The defaults suit one that filters visibility alone, at full size."""

    scales: bool = False
    """Whether it can run at a smaller size, on packed texels that keep depth for the way back."""
    carries: frozenset[str] = frozenset()
    """Outputs that it filters beside visibility: ``bent_normal``, ``gained``."""
    tolerance: float = 0.35
    """Distance off the tangent plane at which upsampling still counts a texel in full, texels."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterJob:
    """What is asked of a filter. tile: width of the noise, texels. scale: pixels to a texel along each side.

    test: which texels there are. signals: what is filtered beside visibility.
    """

    tile: int = 4
    scale: int = 1
    test: DepthTest | None = None
    signals: tuple[str, ...] = ()

    @property
    def result(self) -> str:
        """The resource that it leaves."""
        return VISIBILITY if self.scale == 1 else VISIBILITY_SMALL


class Filter(Protocol):
    """A filter: passes from the packed ``visibility_raw`` (and normals) to :attr:`FilterJob.result`."""

    name: ClassVar[str]

    @property
    def traits(self) -> FilterTraits: ...

    @property
    def radius(self) -> int | None:
        """Half width in texels; None: half of the noise tile."""
        ...

    def passes(self, job: FilterJob) -> list[Pass]:
        """Return its passes, in order."""
        ...


def gaussian(radius: int, sigma: float) -> NDArray[np.float32]:
    """``exp(-i^2 / (2 sigma^2))`` for i = 0 .. radius, float32."""
    return np.exp(-0.5 * (np.arange(radius + 1) / sigma) ** 2).astype(np.float32)


def matched(radius: int) -> NDArray[np.float32]:
    """Weights (1, .., 1, 1/2) for i = 0 .. radius: each phase of a tile ``2 radius`` wide weighs the same, so a noise of that
    period vanishes exactly on smooth surfaces, and the filter stays symmetric."""
    weights = np.ones(radius + 1, np.float32)
    weights[-1] = 0.5
    return weights


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """Separable joint bilateral on depth and normals: a tap counts as far as it lies in the tangent plane of the pixel.

    Full weight up to ``tolerance`` pixels off the plane, none from twice that. The plane distance is measured in the
    size of a pixel at that depth, so no length in scene units is needed and slopes do not fall apart. Where not all taps lie
    in the plane the filter is half as wide: visibility is steep at creases and edges.
    """

    name: ClassVar[str] = "joint"

    radius: int | None = setting(None, "half width; none: half of the method's noise tile", unit="pixels", low=1, high=16)
    sigma: float = setting(
        0.0, "of a Gaussian in space; 0: flat, matched to a tile 2 radius wide", unit="pixels", low=0, high=16
    )
    tolerance: float = setting(
        0.35, "distance off the tangent plane that still counts in full", unit="pixels", above=0, high=1000
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> FilterTraits:
        return FilterTraits(scales=True, carries=frozenset({BENT_NORMAL, GAINED}), tolerance=self.tolerance)

    def passes(self, job: FilterJob) -> list[Pass]:
        names = (VISIBILITY_RAW, VISIBILITY_BLUR_X, job.result)
        return [self._pass(job, axis, names[axis], names[axis + 1]) for axis in (0, 1)]

    def _pass(self, job: FilterJob, axis: int, source: str, result: str) -> Pass:
        radius, scale = self.radius or max(1, job.tile // 2), job.scale
        weights = gaussian(radius, self.sigma) if self.sigma > 0 else matched(radius)
        last = result == VISIBILITY
        more = extra_signals(job.signals, source, result, scale)
        samplers = {"u_packed": source, "u_normal": NORMAL if scale == 1 else NORMAL_SMALL, **more.samplers}
        uniforms: dict[str, Uniform] = {
            "u_next": ViewValue("target_texel", axis=axis),
            "u_step": ViewValue("target_step", axis=axis),
            "u_weights": FloatTable.of(weights),
            "u_per_pixel": ViewValue("pixel", self.tolerance * scale, inverse=True),
        }
        defines: dict[str, Define] = {"PACKED": 1, "RADIUS": radius, **({"LAST": 1} if last else {}), **more.defines}
        if self.sigma == 0 and radius > 1:
            defines["NARROW"] = radius // 2
        draw = Fullscreen("denoise_joint.frag", samplers, uniforms, defines=defines)
        target = Texture("r8") if last else Texture("r32f", 1 / scale)
        writes = {result: target, **more.writes}
        return Pass(f"blur {'xy'[axis]}", "denoise", draw, writes, test=job.test, clear=((1.0 if last else 0.0),) * 4)


@dataclass(frozen=True, slots=True, kw_only=True)
class LectureBlur:
    """The lecture's bilateral filter: ``sum G_s(|p-q|) G_r(|I_q-I_p|) I_q / sum G_s G_r`` over a square, in 2-D.

    The range term looks at the noisy signal itself, so it keeps some of the noise; see ``joint`` for the cure.
    """

    name: ClassVar[str] = "lecture"

    radius: int = setting(4, "half width of the square", unit="pixels", low=1, high=16)
    sigma_space: float = setting(2.0, "of the Gaussian in space", unit="pixels", above=0, high=100)
    sigma_range: float = setting(0.25, "of the Gaussian in visibility", above=0, high=100)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> FilterTraits:
        return FilterTraits()

    def passes(self, job: FilterJob) -> list[Pass]:
        return [_intensity_pass("blur", VISIBILITY_RAW, VISIBILITY, self, (1, 1), job.test)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Separable:
    """The lecture's filter as two 1-D passes: ``2 (2r+1)`` taps for ``(2r+1)^2``. An approximation, with faint crosses at corners."""

    name: ClassVar[str] = "separable"

    radius: int = setting(4, "half width", unit="pixels", low=1, high=32)
    sigma_space: float = setting(2.0, "of the Gaussian in space", unit="pixels", above=0, high=100)
    sigma_range: float = setting(0.25, "of the Gaussian in visibility", above=0, high=100)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> FilterTraits:
        return FilterTraits()

    def passes(self, job: FilterJob) -> list[Pass]:
        return [
            _intensity_pass("blur x", VISIBILITY_RAW, VISIBILITY_BLUR_X, self, (1, 0), job.test),
            _intensity_pass("blur y", VISIBILITY_BLUR_X, VISIBILITY, self, (0, 1), job.test),
        ]


def _intensity_pass(
    name: str, source: str, result: str, blur: LectureBlur | Separable, axes: tuple[int, int], test: DepthTest | None
) -> Pass:
    last, radius = result == VISIBILITY, blur.radius
    defines: dict[str, Define] = {"PACKED": 1, "WIDTH": axes[0] * radius, "HEIGHT": axes[1] * radius, "RADIUS": radius}
    defines |= {"LAST": 1} if last else {}
    weights = FloatTable.of(gaussian(radius, blur.sigma_space))
    uniforms: dict[str, Uniform] = {"u_weights": weights, "u_range": 0.5 / blur.sigma_range**2}
    draw = Fullscreen("denoise_intensity.frag", {"u_packed": source}, uniforms, defines=defines)
    target, clear = (Texture("r8"), (1.0,) * 4) if last else (Texture("r32f"), (0.0,) * 4)
    return Pass(name, "denoise", draw, {result: target}, test=test, clear=clear)


FILTERS: Mapping[str, type[Joint] | type[LectureBlur] | type[Separable]] = {
    kind.name: kind for kind in (Joint, Separable, LectureBlur)
}


def filter_named(name: str) -> Filter | None:
    """Return the filter called ``name`` with its default settings; None for ``"none"``. Raises SettingsError for an unknown
    name."""
    if name == "none":
        return None
    if name not in FILTERS:
        raise SettingsError(f"unknown blur '{name}'; there are none, {', '.join(FILTERS)}.{near_miss(name, FILTERS)}")
    return FILTERS[name]()
