"""Every method by its name: ours, and those of installed packages."""

from __future__ import annotations

import importlib
import importlib.metadata
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, TypeVar

from .. import methods
from ..errors import SettingsError, near_miss

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
    for module in pkgutil.iter_modules(methods.__path__):
        importlib.import_module(f"{methods.__name__}.{module.name}")

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
