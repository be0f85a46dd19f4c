"""Settings from names, TOML files and ``key=value`` texts."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

from .errors import SettingsError, near_miss
from .files import unreadable
from .methods import Method, method, registry
from .passes.blur import BLURS, blur
from .pipeline import RULES, Settings, Shading
from .settings import assign

DEFAULT_METHOD = "bitmask"

NAMES = ("method", "preset", "blur", "normals", "precision", "keep")
"""Settings of their own, in no group."""


def read_toml(path: Path) -> dict[str, Any]:
    """A settings file: ``method`` and ``blur`` by name, and tables ``[blur]``... see :func:`settings_from`. Raises SettingsError."""
    if reason := unreadable(path, empty=True):
        raise SettingsError(f"{path}: {reason}; expected a TOML file with settings")
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:  # TOMLDecodeError and UnicodeDecodeError are ValueErrors
        raise SettingsError(f"{path}: not TOML ({error})") from None


def settings_from(
    table: Mapping[str, Any] | None = None,
    *,
    method_name: str | None = None,
    preset_name: str | None = None,
    blur_name: str | None = None,
    assignments: Iterable[str] = (),
    overrides: Mapping[str, Any] | None = None,
    keep: Iterable[str] = (),
) -> Settings:
    """Settings in rising order of precedence: defaults, the preset, ``table`` (from TOML), names, ``group.key=value`` texts, overrides.

    Groups are ``shading``, ``blur`` (the chosen filter) and the name of the chosen method; a key without a group is the
    method's, but for ``normals`` and ``precision``. ``overrides`` are fields of the method. Raises SettingsError naming what is
    unknown.
    """
    table = dict(table or {})
    chosen: dict[str, Any] = {
        "method": preset(method_name or _text(table, "method", DEFAULT_METHOD), preset_name or _text(table, "preset", "")),
        "blur": blur(blur_name or _text(table, "blur", "joint")),
        "shading": Shading(),
        "normals": _text(table, "normals", "geometric"),
        "precision": _text(table, "precision", "high"),
    }
    chosen["keep"] = _rules([*_names(table, "keep"), *keep])
    name = chosen["method"].name
    groups = {name: "method", "method": "method", "shading": "shading"}
    groups |= {f"blur_{chosen['blur'].name}": "blur"} if chosen["blur"] else {}

    def put(group: str, values: Mapping[str, Any]) -> None:
        if group == "blur" and chosen["blur"] is None:
            raise SettingsError("there is no blur to set anything of: blur is 'none'")
        part = "blur" if group == "blur" else groups.get(group)
        if part is not None:
            chosen[part] = assign(chosen[part], values)
        elif group not in registry() and group not in {f"blur_{b}" for b in BLURS}:  # others' settings may stay in a file
            known = [*groups, "blur"]
            raise SettingsError(
                f"unknown group of settings '{group}'; there are {', '.join(known)}." + near_miss(group, [*known, *registry()])
            )

    for key, value in table.items():
        if isinstance(value, Mapping):
            put(key, value)
        elif key not in NAMES:
            raise SettingsError(f"unknown setting '{key}'; groups are tables, like [{name}].{near_miss(key, NAMES)}")
    for text in assignments:
        key, equals, value = text.partition("=")
        if not equals:
            raise SettingsError(f"--set {text}: must be key=value or group.key=value")
        if key.strip() in ("normals", "precision"):
            chosen[key.strip()] = value.strip()
            continue
        group, dot, field = key.strip().partition(".")
        if dot and group in registry() and group != name:
            raise SettingsError(f"--set {text}: the method is {name}, not {group}; add --method {group}")
        put(group if dot else name, {field if dot else group: value.strip()})
    fields = {f.name for f in dataclasses.fields(chosen["method"])}
    for key, value in (overrides or {}).items():
        if value is not None:
            if key not in fields:
                raise SettingsError(f"--{key}: {name} has no such setting; it has {', '.join(sorted(fields))}")
            chosen["method"] = assign(chosen["method"], {key: value})
    return Settings(**chosen)


def preset(name: str, chosen: str = "") -> Method:
    """The method called ``name`` under one of its presets, as shipped without. Raises SettingsError for unknown names."""
    shipped, presets = method(name), getattr(registry().get(name), "presets", {})
    if chosen and chosen not in presets:
        known = ", ".join(presets) or "none"
        raise SettingsError(f"{name} has no preset '{chosen}'; it has {known}.{near_miss(chosen, presets)}")
    return cast(Method, assign(shipped, presets[chosen]) if chosen else shipped)


def _rules(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(RULES) if "all" in names else tuple(dict.fromkeys(names))


def _names(table: Mapping[str, Any], key: str) -> list[str]:
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise SettingsError(f"{key} = {value!r}: must be a list of names in quotes")
    return value


def _text(table: Mapping[str, Any], key: str, default: str) -> str:
    value = table.get(key, default)
    if isinstance(value, Mapping):  # a table [blur] sets the default filter
        return default
    if not isinstance(value, str):
        raise SettingsError(f"{key} = {value!r}: must be a name in quotes")
    return value
