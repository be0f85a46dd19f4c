"""The lecture's mobile shader, kept as it was taught: for teaching and as a fixed point of comparison."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import ViewValue
from ..graph.names import DEPTH_OVER_FAR, NORMAL
from ..sampling.disk import Kernel, Rotation
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


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
    samplers: ClassVar[Mapping[str, str]] = {"depth": DEPTH_OVER_FAR, "normal": NORMAL}
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

    @property
    def traits(self) -> Traits:
        return Traits(
            cameras=frozenset({"perspective", "far plane"}),
            noise_tile=self.tile,
            radius_unit="share of the image",
            taps_setting="samples",
        )

    def defines(self) -> Mapping[str, int]:
        return {"NSAMPLES": self.samples}

    def constants(self) -> Mapping[str, Any]:
        kernel = Kernel(count=self.samples, distribution=self.distribution, seed=self.seed)
        return {
            "iProjection": ViewValue("inverse_projection"),
            "samples": kernel.points(),
            "radius": ViewValue("image_share", self.radius),
            "ssaoSize": ViewValue("image_size"),
            "rotationWidth": float(self.tile),
            "texelSize": ViewValue("image_texel"),
            "u_far": ViewValue("far"),
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"rotation": Rotation(tile=self.tile, distribution=self.rotation, seed=self.seed).vectors()}
