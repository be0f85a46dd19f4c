"""Spheres at two levels: near ones are pixels around, far ones stand for atoms and for patches of surfaces."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import DEPTH, HIDDEN, NORMAL, PIXEL_DEPTH, PIXEL_NORMAL
from ..sampling import noise
from ..sampling.disk import Kernel
from ..settings import setting, validate
from . import element_settings
from .base import Deviation
from .registry import register
from .traits import ElementTraits, Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class SphereLevels:
    """Spheres at two levels: ``A = (1 - sum over taps of O) (product over far spheres of 1 - O)``. Needs the scene.

    ``O = (r/d)^2 cos theta`` of a sphere above the horizon. Within the near range each tap is a sphere of the area that it stands for.
    Rays that go beyond it, up to the radius, meet far spheres: atoms, exactly, also where they dip below the horizon, and spheres of the area
    of surface patches, by as much as these face the pixel. A ray counts at one of the levels, by where it meets the sphere.
    After Shanmugam and Arikan, "Hardware Accelerated Ambient Occlusion Techniques on GPUs", I3D 2007.

    Time goes with what the spheres' surroundings fill; a setting where that is too much is refused. Volumes hide nothing but near.
    """

    name: ClassVar[str] = "spheres"
    shader: ClassVar[str] = "methods/spheres.frag"
    exceptions: ClassVar[Mapping[str, Deviation]] = {
        "holes-of-any-texture": Deviation(0.4, "what alpha cuts out of a triangle in part makes its patches smaller, all over"),
        "coincident-spheres": Deviation(0.8, "spheres are taken to hide independently: those in one place count each"),
        "scale": Deviation(0.01, "patches are joined by cells of a grid, for which rounding may decide"),
        "rotation": Deviation(0.6, "the grid keeps the axes of the world, and does not turn with a scene"),
    }
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    near: float = setting(0.15, "range of the near level; 0: there is none", unit="radii", low=0, high=1)
    samples: int = setting(16, "taps a pixel of the near level", low=1, high=64)
    patch: float = setting(0.3, "width of surface patches that a far sphere stands for", unit="radii", low=0.05, high=1)
    intensity: float = setting(1.0, "strength: a factor of what spheres hide", low=0, high=16)
    max_radius: float = noise.max_radius()
    scale: int = element_settings.scale()
    sums: str = element_settings.sums()
    max_fill: float = element_settings.max_fill()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        constants = self._near_range() if self.radius is not None else {}
        elements = ElementTraits("spheres", self.sums == "float", 1e6 * self.max_fill, constants, patch=self.patch)
        return Traits(
            inputs=frozenset({"depth", "normal", "scene"}),
            scale=self.scale,
            noise_tile=noise.TILE if self.near else 0,
            max_reach=self.max_radius if self.near else 1.0,
            elements=elements,
        )

    @property
    def samplers(self) -> Mapping[str, str]:
        far = {"u_pixel_z": PIXEL_DEPTH, "u_pixel_normal": PIXEL_NORMAL, "u_hidden": HIDDEN}
        return {**far, "u_z": DEPTH, "u_normal": NORMAL} if self.near else far

    def defines(self) -> Mapping[str, Define]:
        return {"SAMPLES": self.samples if self.near else 0}

    def constants(self) -> Mapping[str, Any]:
        points = Kernel(count=self.samples).points().astype(np.float64)
        away = np.linalg.norm(points, axis=1, keepdims=True)  # of which the square is uniform
        near = {"u_points": np.hstack([points * away, 2 * away**2 / self.samples]).astype(np.float32), **self._near_range()}
        return {"u_strength": self.intensity, **(near if self.near else {})}

    def _near_range(self) -> Mapping[str, Any]:
        return noise.reach_uniforms(None if self.radius is None else self.near * self.radius, self.max_radius)

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_rotation": noise.tile_directions(math.pi)} if self.near else {}
