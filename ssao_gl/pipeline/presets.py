"""Settings from names, TOML files and ``key=value`` texts."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..errors import SettingsError, near_miss
from ..io.atomic import why_unreadable
from ..methods.registry import DEFAULT_METHOD, method, registry
from ..passes.denoise import FILTERS, filter_named
from ..settings import assign
from .light import Light
from .settings import CULLING_RULES, Settings, Shading

COUNTS = ("slices", "directions", "pairs", "steps")
"""Settings that stand for the number of taps, where a method has no ``samples``."""

NAMES = ("method", "preset", "blur", "normals", "precision", "rays", "supersample", "exclude", "keep")
"""Settings of their own, in no group."""


def read_toml(path: Path) -> dict[str, Any]:
    """Read a settings file: ``method`` and ``blur`` by name, and tables ``[blur]``... see :func:`settings_from`.

    Raises SettingsError.
    """
    if reason := why_unreadable(path, empty=True):
        raise SettingsError(f"{path}: {reason}; expected a TOML file with settings")
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:  # TOMLDecodeError and UnicodeDecodeError are ValueErrors
        raise SettingsError(f"{path}: not TOML ({error})") from None


def settings_toml(table: Mapping[str, Any]) -> str:
    """Return :meth:`Settings.table` as the text of a TOML file that :func:`settings_from` reads; what is automatic is left out."""
    import tomli_w

    def told(values: Mapping[str, Any]) -> dict[str, Any]:
        return {key: told(v) if isinstance(v, Mapping) else v for key, v in values.items() if v is not None}

    return tomli_w.dumps(told(table))


def settings_from(
    table: Mapping[str, Any] | None = None,
    *,
    method_name: str | None = None,
    preset_name: str | None = None,
    blur_name: str | None = None,
    assignments: Iterable[str] = (),
    overrides: Mapping[str, Any] | None = None,
    keep: Iterable[str] = (),
    rays: float | None = None,
    supersample: int | None = None,
) -> Settings:
    """Return settings in rising order of precedence: defaults, the preset, ``table`` (from TOML), names, ``group.key=value``
    texts, overrides.

    Groups are ``shading``, ``light``, ``filter_named`` (the chosen filter) and the name of the chosen method; a key without a group is the
    method's, but for ``normals``, ``precision``, ``rays`` and ``supersample``. ``overrides`` are fields of the method. Raises SettingsError naming what is
    unknown.
    """
    table = dict(table or {})
    chosen = _Chosen(
        {
            "method": method(method_name or _text(table, "method", DEFAULT_METHOD), preset_name or _text(table, "preset", "")),
            "blur": filter_named(blur_name or _text(table, "blur", "joint")),
            "shading": Shading(),
            "light": None,
            "normals": _text(table, "normals", "geometric"),
            "precision": _text(table, "precision", "high"),
            "rays": table.get("rays", 0.0) if rays is None else rays,
            "supersample": table.get("supersample", 1) if supersample is None else supersample,
            "exclude": tuple(_names(table, "exclude")),
            "keep": _rules([*_names(table, "keep"), *keep]),
        }
    )
    for key, value in table.items():
        chosen.put_entry(key, value)
    for text in assignments:
        chosen.put_text(text)
    for key, value in (overrides or {}).items():
        if value is not None:
            chosen.put_field(key, value)
    return Settings(**chosen.parts)


@dataclasses.dataclass(frozen=True)
class _Chosen:
    """Settings in the making: their fields by name."""

    parts: dict[str, Any]

    @property
    def method(self) -> str:
        return str(self.parts["method"].name)

    def put(self, group: str, values: Mapping[str, Any]) -> None:
        """Values of a group: ``shading``, ``light``, ``filter_named``, or a method or a filter by its name."""
        groups = {self.method: "method", "method": "method", "shading": "shading", "light": "light"}
        if self.parts["blur"] is not None:
            groups |= dict.fromkeys(("blur", f"blur_{self.parts['blur'].name}"), "blur")
        elif group == "blur":
            raise SettingsError("there is no blur to set anything of: blur is 'none'")
        if part := groups.get(group):
            self.parts[part] = assign(Light() if self.parts[part] is None else self.parts[part], values)
        elif group not in registry() and group not in {f"blur_{b}" for b in FILTERS}:  # others' settings may stay in a file
            known = list(dict.fromkeys([*groups, "blur"]))
            raise SettingsError(
                f"unknown group of settings '{group}'; there are {', '.join(known)}." + near_miss(group, [*known, *registry()])
            )

    def put_entry(self, key: str, value: Any) -> None:
        """Put an entry of a TOML file."""
        if isinstance(value, Mapping):
            self.put(key, value)
        elif key not in NAMES:
            raise SettingsError(f"unknown setting '{key}'; groups are tables, like [{self.method}].{near_miss(key, NAMES)}")

    def put_text(self, text: str) -> None:
        """``key=value`` or ``group.key=value``."""
        key, equals, value = text.partition("=")
        if not equals:
            raise SettingsError(f"--set {text}: must be key=value or group.key=value")
        key, value = key.strip(), value.strip()
        if key in ("normals", "precision", "rays", "supersample"):
            self.parts[key] = {"rays": as_rays, "supersample": as_samples}.get(key, str)(value)
            return
        group, dot, field = key.partition(".")
        if dot and group in registry() and group != self.method:
            raise SettingsError(f"--set {text}: the method is {self.method}, not {group}; add --method {group}")
        self.put(group if dot else self.method, {field if dot else group: value})

    def put_field(self, key: str, value: Any) -> None:
        """Put a field of the method, by an option of its own."""
        fields = sorted(f.name for f in dataclasses.fields(self.parts["method"]))
        if key not in fields:
            ways = _ways_to_count(self.parts["method"]) if key == "samples" else ""
            raise SettingsError(f"--{key}: {self.method} has no such setting; {ways or 'it has ' + ', '.join(fields)}")
        self.parts["method"] = assign(self.parts["method"], {key: value})


def as_rays(text: str) -> float:
    """Return rays a pixel from a number, or from a fraction like 1/4. Raises SettingsError."""
    above, slash, below = text.partition("/")
    try:
        return float(above) / (float(below) if slash else 1.0)
    except (ValueError, ZeroDivisionError):
        raise SettingsError(f"rays={text}: must be a number of rays a pixel, like 0.25, 1/4 or 2") from None


def as_samples(text: str) -> int:
    """Return samples a pixel along each side. Raises SettingsError."""
    try:
        return int(text)
    except ValueError:
        raise SettingsError(f"supersample={text}: must be a whole number, 1 to 3") from None


def _ways_to_count(record: Any) -> str:
    """Return what to type where a method counts its taps by settings of other names; nothing where it does not."""
    ways = [f"--set {f.name}={getattr(record, f.name)}" for f in dataclasses.fields(record) if f.name in COUNTS]
    return f"its taps are set by {' '.join(ways)} (what it has now), or by --preset" if ways else ""


def _rules(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(CULLING_RULES) if "all" in names else tuple(dict.fromkeys(names))


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
