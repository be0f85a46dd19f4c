"""What an ambient-occlusion method is."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from .traits import Traits


@dataclass(frozen=True, slots=True)
class Deviation:
    """A contract that a method's published definition breaks: by how much at most, and why."""

    bound: float
    """Largest deviation, in the measure of that contract's test; inf where the method refuses instead."""
    reason: str


@runtime_checkable
class Method(Protocol):
    """An ambient-occlusion method: a frozen dataclass of settings with a shader. Lengths are in scene units unless it says otherwise."""

    name: ClassVar[str]
    shader: ClassVar[str]
    """Fragment shader: below ``shaders/``, or beside the module of the method."""
    exceptions: ClassVar[Mapping[str, Deviation]]
    """Contracts (``ssao-gl stress --list``) that the published definition breaks. Empty for good methods."""
    presets: ClassVar[Mapping[str, Mapping[str, Any]]]
    """Name -> values of settings; the report sweeps over them. Empty: there is one way to run it."""

    @property
    def radius(self) -> Any: ...

    @property
    def traits(self) -> Traits:
        """What the pipeline may ask of it."""
        ...

    @property
    def samplers(self) -> Mapping[str, str]:
        """Sampler uniform -> resource, of :mod:`ssao_gl.graph.names`."""
        ...

    def defines(self) -> Mapping[str, Define]:
        """Return what is compiled into the shader."""
        ...

    def constants(self) -> Mapping[str, Any]:
        """Return the uniforms that settings decide: numbers, tuples, arrays, and ViewValues for what depends on the view.

        Raises SettingsError when the radius is not settled.
        """
        ...

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        """Return small repeating textures (h, w, channels) by sampler uniform. ``outputs``: what is drawn beside visibility."""
        ...
