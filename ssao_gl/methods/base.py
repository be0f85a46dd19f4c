"""What an ambient-occlusion method is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..glsl.preprocess import Define
from ..scene.projection import ViewConstants


@dataclass(frozen=True, slots=True)
class Deviation:
    """A contract that a method's published definition breaks: by how much at most, and why."""

    bound: float
    """Largest deviation, in the measure of that contract's test; inf where the method refuses instead."""
    reason: str


@runtime_checkable
class Method(Protocol):
    """What an AO method is: a frozen dataclass with a shader. Lengths are in scene units unless it says otherwise."""

    name: ClassVar[str]
    shader: ClassVar[str]
    """Fragment shader, below ``shaders/``."""
    exceptions: ClassVar[Mapping[str, Deviation]]
    """Contracts (see ``tests/gl/test_contract.py``) that the published definition breaks. Empty for good methods."""
    # Optional: presets: ClassVar[Mapping[str, Mapping[str, Any]]], name -> values of fields; the report sweeps over them.

    @property
    def radius(self) -> Any: ...

    @property
    def samplers(self) -> Mapping[str, str]:
        """Sampler uniform -> resource: ``z``, ``normal``, ``z_over_far``, ``z2`` (the layer behind)."""
        ...

    def defines(self) -> Mapping[str, Define]:
        """What is compiled into the shader."""
        ...

    def uniforms(self, view: ViewConstants) -> Mapping[str, Any]:
        """What the shader is given for a view: the mapping from settings to constants. Pure."""
        ...

    def lookups(self) -> Mapping[str, NDArray[np.float32]]:
        """Sampler uniform -> small repeating table (h, w, 2)."""
        ...
