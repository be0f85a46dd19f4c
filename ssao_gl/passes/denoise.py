"""Bilateral filters of visibility. All leave background out and renormalise by the weights that remain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError, near_miss
from ..gl.executor import Stage
from ..graph.declare import DepthTest, Pass, Texture
from ..settings import setting, validate
from .bent_normals import extra_signal


class Filter(Protocol):
    """A filter: passes from the packed ``raw`` (and ``normal``) to ``visibility``."""

    name: ClassVar[str]

    def passes(self, tile: int = 4, cover: DepthTest | None = None) -> list[Pass]:
        """At full size. ``tile``: width of the noise, pixels. ``cover``: which pixels there are."""
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
    size of a pixel at that depth, so no length in scene units is needed and slopes do not fall apart.
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

    def passes(self, tile: int = 4, cover: DepthTest | None = None, *, bent: bool = False) -> list[Pass]:
        names = ("raw", "blurred x", "visibility")
        return [self._pass(axis, names[axis], names[axis + 1], tile, 1, cover, bent) for axis in (0, 1)]

    def small_passes(self, tile: int, scale: int, test: DepthTest | None, *, bent: bool = False) -> list[Pass]:
        """The same at a smaller size, to ``small visibility``, which keeps depth for the way back to full size."""
        names = ("raw", "blurred x", "small visibility")
        return [self._pass(axis, names[axis], names[axis + 1], tile, scale, test, bent) for axis in (0, 1)]

    def _pass(self, axis: int, source: str, result: str, tile: int, scale: int, test: DepthTest | None, bent: bool) -> Pass:
        radius = self.radius or max(1, tile // 2)
        weights = gaussian(radius, self.sigma) if self.sigma > 0 else matched(radius)
        last = result == "visibility"
        more = extra_signal(bent, source, result, scale)
        samplers = {"u_packed": source, "u_normal": "normal" if scale == 1 else "small normal", **more.samplers}

        def draw(stage: Stage) -> None:
            texel, step = [0.0, 0.0], [0.0, 0.0]
            texel[axis], step[axis] = 1 / stage.step.size[axis], scale / stage.view.size[axis]
            uniforms = {
                "u_next": tuple(texel),
                "u_step": tuple(step),
                "u_weights": weights,
                "u_per_pixel": 1 / (self.tolerance * scale * stage.view.pixel),
            }
            defines = {"PACKED": 1, "RADIUS": radius, **({"LAST": 1} if last else {}), **more.defines}
            stage.fullscreen("blur_joint.frag", uniforms, samplers, defines=defines)

        target = Texture("r8") if last else Texture("r32f", 1 / scale)
        clear = (1.0,) * 4 if last else (0.0,) * 4
        writes = {result: target, **more.writes}
        return Pass(f"blur {'xy'[axis]}", tuple(samplers.values()), writes, draw, test=test, clear=clear)


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

    def passes(self, tile: int = 4, cover: DepthTest | None = None) -> list[Pass]:
        return [_intensity_pass("blur", "raw", "visibility", self, (1, 1), cover)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Separable:
    """The lecture's filter as two 1-D passes: ``2 (2r+1)`` taps for ``(2r+1)^2``. An approximation, with faint crosses at corners."""

    name: ClassVar[str] = "separable"

    radius: int = setting(4, "half width", unit="pixels", low=1, high=32)
    sigma_space: float = setting(2.0, "of the Gaussian in space", unit="pixels", above=0, high=100)
    sigma_range: float = setting(0.25, "of the Gaussian in visibility", above=0, high=100)

    def __post_init__(self) -> None:
        validate(self)

    def passes(self, tile: int = 4, cover: DepthTest | None = None) -> list[Pass]:
        return [
            _intensity_pass("blur x", "raw", "blurred x", self, (1, 0), cover),
            _intensity_pass("blur y", "blurred x", "visibility", self, (0, 1), cover),
        ]


def _intensity_pass(
    name: str, source: str, result: str, filter_named: LectureBlur | Separable, axes: tuple[int, int], cover: DepthTest | None
) -> Pass:
    weights = gaussian(filter_named.radius, filter_named.sigma_space)
    last = result == "visibility"
    defines = {
        "PACKED": 1,
        "WIDTH": axes[0] * filter_named.radius,
        "HEIGHT": axes[1] * filter_named.radius,
        "RADIUS": filter_named.radius,
    }
    uniforms = {"u_weights": weights, "u_range": 0.5 / filter_named.sigma_range**2}

    def draw(stage: Stage) -> None:
        every = {**defines, **({"LAST": 1} if last else {})}
        stage.fullscreen("blur_intensity.frag", uniforms, {"u_packed": source}, defines=every)

    target, clear = (Texture("r8"), (1.0,) * 4) if last else (Texture("r32f"), (0.0,) * 4)
    return Pass(name, (source,), {result: target}, draw, test=cover, clear=clear)


FILTERS: Mapping[str, type[Joint] | type[LectureBlur] | type[Separable]] = {
    kind.name: kind for kind in (Joint, Separable, LectureBlur)
}


def filter_named(name: str) -> Filter | None:
    """The filter called ``name`` with its default settings; None for ``"none"``. Raises SettingsError for an unknown name."""
    if name == "none":
        return None
    if name not in FILTERS:
        raise SettingsError(f"unknown blur '{name}'; there are none, {', '.join(FILTERS)}.{near_miss(name, FILTERS)}")
    return FILTERS[name]()
