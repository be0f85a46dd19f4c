"""Lamps of a scene: suns, bulbs and spots, as glTF's KHR_lights_punctual describes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .camera import Camera
from .projection import ViewConstants

LampKind = Literal["directional", "point", "spot"]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LitView:
    """What a frame brings to the passes that light it: values of their uniforms, and the eyes that they draw through, by name."""

    values: Mapping[str, Any] = field(default_factory=dict)
    eyes: Mapping[str, tuple[Camera, ViewConstants]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Lamp:
    """A light without extent, in world space.

    color: linear (r, g, b) times intensity: what falls on a surface that faces a directional one, what goes into a unit of solid
    angle of the others (glTF: lux and candela). place: of point and spot. direction: unit, in which a directional one and the
    middle of a spot shine. range: scene units beyond which nothing arrives; None: endless. cone: inner and outer half angle of a
    spot, radians.
    """

    kind: LampKind
    color: Triple = (1.0, 1.0, 1.0)
    place: Triple = (0.0, 0.0, 0.0)
    direction: Triple = (0.0, 0.0, -1.0)
    range: float | None = None
    cone: tuple[float, float] = (0.0, math.pi / 4)
    name: str = ""

    def __post_init__(self) -> None:
        where = f"light '{self.name}'" if self.name else "light"
        if self.kind not in ("directional", "point", "spot"):
            raise SceneError(f"{where}: is '{self.kind}'; must be directional, point or spot")
        numbers = np.array([*self.color, *self.place, *self.direction, *self.cone], np.float64)
        if not np.isfinite(numbers).all() or min(self.color) < 0:
            raise SceneError(f"{where}: must have finite numbers, and a color that is nowhere below 0")
        if self.range is not None and not 0 < self.range < math.inf:
            raise SceneError(f"{where}: range is {self.range:g}; it must be above 0")
        if not 0 <= self.cone[0] <= self.cone[1] <= math.pi / 2:
            raise SceneError(f"{where}: cone is {self.cone}; it must rise from 0 to pi/2 at most")
        length = float(np.linalg.norm(self.direction))
        if not length > 0:
            raise SceneError(f"{where}: has no direction")
        x, y, z = (part / length for part in self.direction)
        object.__setattr__(self, "direction", (x, y, z))

    @classmethod
    def hung(
        cls,
        kind: LampKind,
        pose: NDArray[np.float64],
        color: Triple,
        range: float | None,
        cone: tuple[float, float],
        name: str = "",
    ) -> Lamp:
        """Return a lamp that shines along -z of ``pose`` (4, 4). Raises SceneError."""
        place, direction = (tuple(column.tolist()) for column in (pose[:3, 3], -pose[:3, 2]))
        return cls(kind, color, place, direction, range, cone, name)

    def brighter(self, factor: float) -> Lamp:
        """Return the same lamp, ``factor`` times as bright."""
        r, g, b = (factor * part for part in self.color)
        return replace(self, color=(r, g, b))

    def reaches(self, point: NDArray[np.float64]) -> float:
        """Return how much light falls on a surface that faces it at ``point`` (3,), without its colour."""
        if self.kind == "directional":
            return max(self.color)
        away = float(np.linalg.norm(np.asarray(self.place) - point))
        return max(self.color) / max(away * away, 1e-30)
