"""What a file keeps: visibility that was baked into its vertices or textures."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import BAKED, DEPTH
from ..sampling import noise
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class BakedOcclusion:
    """Visibility that the scene's file keeps: ``A = 1 - s (1 - a)``, ``a`` of a mesh's vertices or of its texture. No noise, no filter.

    Of a glTF file it is the attribute _AO, else the occlusion texture (red, glTF 2.0 of 2017, 3.9.3), else COLOR_0 where that is grey; meshes
    without any are open. A scene that keeps nothing is refused. ``ssao-gl bake`` makes such files.
    """

    name: ClassVar[str] = "baked"
    shader: ClassVar[str] = "methods/baked.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_baked": BAKED}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    intensity: float = setting(1.0, "strength; 0: all is open, 1: as it is kept", low=0, high=16)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(inputs=frozenset({"depth", "baked"}), noise_tile=0)

    def defines(self) -> Mapping[str, Define]:
        return {}

    def constants(self) -> Mapping[str, Any]:
        return {"u_strength": self.intensity}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {}
