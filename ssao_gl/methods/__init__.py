"""Ambient-occlusion methods: each is one settings record here and one shader in ``shaders/methods``.

A method registers itself; the command line, the report and the tests find it in :func:`registry`. Other packages add
theirs by the entry-point group ``ssao_gl.methods``.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError, near_miss
from ..sources import Define
from ..view import View


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

    def uniforms(self, view: View) -> Mapping[str, Any]:
        """What the shader is given for a view: the mapping from settings to constants. Pure."""
        ...

    def lookups(self) -> Mapping[str, NDArray[np.float32]]:
        """Sampler uniform -> small repeating table (h, w, 2)."""
        ...


AnyMethod = TypeVar("AnyMethod", bound=type)
_METHODS: dict[str, type] = {}


def register(method: AnyMethod) -> AnyMethod:
    """Class decorator that makes a method known by its name. Raises SettingsError when the name is taken."""
    name = method.name  # type: ignore[attr-defined]
    if name in _METHODS and _METHODS[name].__qualname__ != method.__qualname__:
        raise SettingsError(f"two AO methods are called '{name}'")
    _METHODS[name] = method
    return method


@cache
def registry() -> Mapping[str, type]:
    """Every method by name: ours first, then those of installed packages."""
    from . import alchemy, bitmask, crytek, gtao, hbao, lecture, reference, sao, starcraft2, volumetric  # noqa: F401

    for entry in importlib.metadata.entry_points(group="ssao_gl.methods"):
        register(entry.load())
    return dict(_METHODS)


def method(name: str) -> Any:
    """The method called ``name`` with its default settings. Raises SettingsError for an unknown name."""
    known = registry()
    if name not in known:
        raise SettingsError(f"unknown method '{name}'; there are {', '.join(known)}.{near_miss(name, known)}")
    return known[name]()


def presets_of(name: str) -> Mapping[str, Mapping[str, Any]]:
    """The presets of the method called ``name``, by name: values of fields. They are optional."""
    made: Mapping[str, Mapping[str, Any]] = getattr(registry().get(name), "presets", {})
    return made


def check_presets(asked: Iterable[str], known: Iterable[str]) -> None:
    """Raise SettingsError for the first of ``--presets`` that is not among ``known``."""
    known = list(dict.fromkeys(known))
    for preset in asked:
        if preset not in known:
            raise SettingsError(
                f"--presets {preset}: no method has it; there are {', '.join(known)}.{near_miss(preset, known)}"
            )
