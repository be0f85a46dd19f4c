"""Every method by its name: ours, and those of installed packages."""

from __future__ import annotations

import importlib
import importlib.metadata
import logging
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, TypeVar

from .. import methods
from ..errors import SettingsError, near_miss, one_line
from ..glsl import preprocess
from ..settings import assign
from .base import Method
from .traits import Traits

AnyMethod = TypeVar("AnyMethod", bound=type)
DEFAULT_METHOD = "bitmask"
"""The method where none is named; it is listed first."""
_METHODS: dict[str, type[Method]] = {}
_OPTIONAL: Mapping[str, Any] = {"presets": {}, "exceptions": {}, "traits": Traits()}
"""Members that a method may leave out, and what they are then."""
_NEEDED = ("name", "shader", "radius", "samplers", "defines", "constants", "tables")

log = logging.getLogger("ssao_gl")


def register(method: AnyMethod) -> AnyMethod:
    """Make a method known by its name; a class decorator.

    Its shader may lie beside its module. Raises SettingsError when the name is taken, or a member is missing.
    """
    members = {member for kind in method.__mro__ for member in vars(kind)} | set(method.__dataclass_fields__)  # type: ignore[attr-defined]
    if missing := [member for member in _NEEDED if member not in members]:
        raise SettingsError(f"the AO method {method.__name__} has no {', '.join(missing)}; see ssao_gl.methods.base.Method")
    for member, default in _OPTIONAL.items():
        if member not in members:
            setattr(method, member, default)
    found: type[Method] = method
    if found.name in _METHODS and _METHODS[found.name].__qualname__ != found.__qualname__:
        raise SettingsError(f"two AO methods are called '{found.name}'")
    if not found.__module__.startswith(f"{methods.__name__}.") and found.shader not in preprocess.names():
        found.shader = preprocess.beside(found.__module__, found.shader)
    _METHODS[found.name] = found
    return method


@cache
def registry() -> Mapping[str, type[Method]]:
    """Return every method by name: ours first, then those of installed packages. A package that fails is left out, and named."""
    for module in pkgutil.iter_modules(methods.__path__):
        importlib.import_module(f"{methods.__name__}.{module.name}")
    for entry in importlib.metadata.entry_points(group="ssao_gl.methods"):
        try:
            register(entry.load())
        except Exception as error:  # somebody else's code may fail in any way
            where = f"{entry.name} ({entry.value})"
            log.warning("the AO method %s cannot be used: %s: %s", where, type(error).__name__, one_line(error, 200))
    # Not as they happened to be imported: the default first, ours by name, then those of others.
    ours = [name for name, kind in _METHODS.items() if kind.__module__.startswith(f"{methods.__name__}.")]
    order = [*sorted(ours, key=lambda name: (name != DEFAULT_METHOD, name)), *(name for name in _METHODS if name not in ours)]
    return {name: _METHODS[name] for name in order}


def general() -> list[str]:
    """Return the names of the methods that draw every scene, whatever it keeps."""
    return [name for name, kind in registry().items() if kind().traits.any_scene]


def method(name: str, preset: str = "", **changes: Any) -> Any:
    """Return the method called ``name`` under one of its presets, with some settings changed.

        ssao_gl.method("bitmask", "draft", radius=0.3)

    Without a preset it is as shipped. Raises SettingsError for unknown names and for values that do not fit.
    """
    known = registry()
    if name not in known:
        raise SettingsError(f"unknown method '{name}'; there are {', '.join(known)}.{near_miss(name, known)}")
    presets = presets_of(name)
    if preset and preset not in presets:
        raise SettingsError(
            f"{name} has no preset '{preset}'; it has {', '.join(presets) or 'none'}.{near_miss(preset, presets)}"
        )
    return assign(known[name](), {**(presets[preset] if preset else {}), **changes})


def presets_of(name: str) -> Mapping[str, Mapping[str, Any]]:
    """Return the presets of the method called ``name``, by name: values of settings. None for an unknown method."""
    return registry()[name].presets if name in registry() else {}


def check_presets(asked: Iterable[str], known: Iterable[str]) -> None:
    """Raise SettingsError for the first of ``--presets`` that is not among ``known``."""
    known = list(dict.fromkeys(known))
    for preset in asked:
        if preset not in known:
            raise SettingsError(
                f"--presets {preset}: no method has it; there are {', '.join(known)}.{near_miss(preset, known)}"
            )
