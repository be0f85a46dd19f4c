"""The lecture's mobile shader, kept as it was taught: for teaching and as a fixed point of comparison."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..sampling.disk import Kernel, Rotation
from ..scene.projection import ViewConstants
from ..settings import setting, validate
from .base import Deviation
from .registry import register


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Lecture:
    """Alchemy-style occlusion of the lecture's GLES shader: N taps, ``1 - sum(a b c) / N``.

    ``a = smoothstep(0, 1, v.n)``, ``b = 1 - n_p.n_q``, ``c = step(|d_q - d_p|, 0.05)`` with ``d = z / far`` and taps at
    ``uv + radius (1 - d) reflect(sample, rotation)``. Source: lecture "Ambient occlusion", UPC Barcelona, after
    M. Sunet, "Ambient Occlusion on Mobile: An Empirical Comparison", master thesis, UPC 2016.

    What that means: the footprint is a share of the image, not a length (it depends on the far plane and is an ellipse
    on images that are not square); there is no falloff with distance; ``b`` reaches 2, so faces back to back count
    double and parallel ones not at all; taps outside the image read its border.
    """

    name: ClassVar[str] = "lecture"
    shader: ClassVar[str] = "methods/lecture.frag"
    samplers: ClassVar[Mapping[str, str]] = {"depth": "z_over_far", "normal": "normal"}
    exceptions: ClassVar[Mapping[str, Deviation]] = {
        "orthographic": Deviation(math.inf, "far-plane point times depth holds for a perspective only; it refuses others"),
        "infinite far": Deviation(math.inf, "depth is z / far; it refuses a camera without a far plane"),
        "pit": Deviation(1.0, "faces that are parallel do not occlude each other: the bottom of a pit is as bright as its rim"),
        "far plane": Deviation(0.25, "footprint and depth window are shares of the far distance"),
        "border": Deviation(0.5, "taps outside the image read its border"),
    }
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {str(taps): {"samples": taps} for taps in (4, 8, 16)}

    radius: float = setting(
        0.08, "footprint at depth 0, shrinking to 0 at the far plane", unit="share of the image", low=0, high=2
    )
    samples: int = setting(4, "taps a pixel", low=1, high=64)
    distribution: str = setting("spiral", "of the taps in the disk", choices=("spiral", "hammersley", "uniform"))
    tile: int = setting(4, "width of the rotation texture", unit="pixels", low=1, high=64)
    rotation: str = setting("stratified", "how its vectors are spread", choices=("stratified", "random"))
    seed: int = setting(0, "of kernel and rotation", low=0, high=2**31 - 1)

    def __post_init__(self) -> None:
        validate(self)

    def defines(self) -> Mapping[str, int]:
        return {"NSAMPLES": self.samples}

    def uniforms(self, view: ViewConstants) -> Mapping[str, Any]:
        """Raises SettingsError for a camera without a far plane or with parallel rays, for which it is not defined."""
        if not view.pinhole:
            raise SettingsError("lecture: is defined for perspective cameras only; use another method")
        if not math.isfinite(view.far):
            raise SettingsError("lecture: needs a far plane, since its depth is z / far; give zfar, or use another method")
        kernel = Kernel(count=self.samples, distribution=self.distribution, seed=self.seed)
        return {
            "iProjection": np.linalg.inv(view.projection).T,
            "samples": kernel.points(),
            "radius": tuple(self.radius * whole / side for whole, side in zip(view.whole or view.size, view.size, strict=True)),
            "ssaoSize": tuple(map(float, view.size)),
            "rotationWidth": float(self.tile),
            "texelSize": (1 / view.size[0], 1 / view.size[1]),
            "u_far": view.far,
        }

    def lookups(self) -> Mapping[str, NDArray[np.float32]]:
        return {"rotation": Rotation(tile=self.tile, distribution=self.rotation, seed=self.seed).vectors()}
