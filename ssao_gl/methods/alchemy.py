"""Alchemy ambient obscurance with a world-space radius."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..graph.names import DEPTH, NORMAL
from ..sampling.disk import Kernel, Rotation
from ..sampling.falloff import CORNER
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Alchemy:
    """Alchemy ambient obscurance: point samples on a disk, each weighing ``max(0, v.n - z beta) / (v.v + eps)``.

    ``A = max(0, 1 - 2 sigma/s sum)^k``. McGuire, Osman, Bukowski, Hennessy, "The Alchemy Screen-Space Ambient Obscurance
    Algorithm", HPG 2011. Sigma scales with the radius and is calibrated (see ``CORNER``) so that the corner of two
    walls comes out half occluded. Taps outside the image are left out of the mean.
    """

    name: ClassVar[str] = "alchemy"
    shader: ClassVar[str] = "methods/alchemy.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "draft": {"samples": 4},
        "low": {"samples": 8},
        "medium": {"samples": 16},
        "high": {"samples": 32},
    }

    radius: float | None = setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)
    samples: int = setting(12, "taps a pixel", low=1, high=128)
    intensity: float = setting(1.0, "strength; at 1 the corner of two walls is half occluded", low=0, high=16)
    bias: float = setting(0.001, "raise it if flat surfaces speckle", unit="share of the distance to the eye", low=0, high=0.1)
    power: float = setting(1.0, "contrast, applied last", above=0, high=16)
    max_radius: float = setting(
        256.0, "largest footprint; nearer surfaces get a smaller reach", unit="pixels", low=1, high=4096
    )
    distribution: str = setting("spiral", "of the taps in the disk", choices=("spiral", "hammersley", "uniform"))
    tile: int = setting(4, "width of the rotation texture", unit="pixels", low=1, high=64)
    rotation: str = setting("stratified", "how its vectors are spread", choices=("stratified", "random"))
    seed: int = setting(0, "of kernel and rotation", low=0, high=2**31 - 1)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(noise_tile=self.tile, max_reach=self.max_radius, taps_setting="samples")

    def defines(self) -> Mapping[str, int]:
        return {"SAMPLES": self.samples}

    def constants(self) -> Mapping[str, Any]:
        if self.radius is None:
            raise SettingsError("the radius must be settled before the draw")
        kernel = Kernel(count=self.samples, distribution=self.distribution, seed=self.seed)
        return {
            "u_samples": kernel.points(),
            "u_radius": self.radius,
            "u_bias": self.bias,
            "u_strength": 2 * CORNER * self.intensity,
            "u_power": self.power,
            "u_max_radius": self.max_radius,
            "u_rotation_width": float(self.tile),
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_rotation": Rotation(tile=self.tile, distribution=self.rotation, seed=self.seed).vectors()}
