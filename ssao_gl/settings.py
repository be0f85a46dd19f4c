"""Settings are frozen dataclasses whose fields carry their own documentation, unit and range.

The same fields make the Python signature, the check, the help of the command line, ``--set`` and TOML files.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

from .errors import SettingsError, near_miss

Record = TypeVar("Record")


@dataclass(frozen=True, slots=True)
class Limits:
    """What a setting means and may be. ``above`` is exclusive, ``low`` and ``high`` are inclusive."""

    doc: str
    unit: str = ""
    above: float | None = None
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()

    def describe(self) -> str:
        """Return the range in words."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        parts = [f"above {self.above:g}"] if self.above is not None else []
        if self.low is not None and self.high is not None:
            parts.append(f"{self.low:g} to {self.high:g}")
        elif self.low is not None:
            parts.append(f"at least {self.low:g}")
        elif self.high is not None:
            parts.append(f"at most {self.high:g}")
        return ", ".join(parts)


def setting(default: Any, doc: str, **limits: Any) -> Any:
    """Return a dataclass field with documentation and limits (see :class:`Limits`)."""
    return dataclasses.field(default=default, metadata={"limits": Limits(doc, **limits)})


def limits(field: dataclasses.Field[Any]) -> Limits:
    """Return what :func:`setting` noted for ``field``."""
    found = field.metadata.get("limits")
    return found if found is not None else Limits("")


def title(record: object) -> str:
    """Return the name users know a settings record by."""
    kind = record if isinstance(record, type) else type(record)
    return getattr(kind, "name", None) or kind.__name__.lower()


def validate(record: Any) -> None:
    """Check every field of ``record`` against its type and limits. Raises SettingsError naming the field."""
    hints = _hints(type(record))  # type: ignore[arg-type]
    for field in dataclasses.fields(record):
        value, rule = getattr(record, field.name), limits(field)
        name = f"{title(record)}.{field.name}={value!r}"
        optional, kind = _kind(hints[field.name])
        if value is None and optional:
            continue
        if kind in (int, float):
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not _finite(value) or (kind is int and value != int(value)):
                raise SettingsError(f"{name}: must be a finite {'whole ' if kind is int else ''}number")
            wrong = (
                (rule.above is not None and value <= rule.above)
                or (rule.low is not None and value < rule.low)
                or (rule.high is not None and value > rule.high)
            )
            if wrong:
                unit = f" ({rule.unit})" if rule.unit else ""
                raise SettingsError(f"{name}: must be {rule.describe()}{unit}")
        elif kind in (str, bool) and not isinstance(value, kind):
            raise SettingsError(f"{name}: must be {'text' if kind is str else 'true or false'}")
        if rule.choices and value not in rule.choices:
            raise SettingsError(f"{name}: must be {rule.describe()}.{near_miss(str(value), rule.choices)}")


def _finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def assign(record: Record, values: Mapping[str, Any]) -> Record:
    """``record`` with some fields replaced; texts are converted to the field's type. Raises SettingsError."""
    fields = {field.name: field for field in dataclasses.fields(record)}  # type: ignore[arg-type]
    hints = _hints(type(record))  # type: ignore[arg-type]
    changes = {}
    for name, value in values.items():
        if name not in fields:
            known = ", ".join(fields) or "none"
            raise SettingsError(f"{title(record)} has no setting '{name}'; it has: {known}.{near_miss(name, fields)}")
        optional, kind = _kind(hints[name])
        changes[name] = _convert(f"{title(record)}.{name}", value, kind, optional)
    return dataclasses.replace(record, **changes)  # type: ignore[type-var]


def as_table(record: Any) -> dict[str, Any]:
    """Return the fields of a record, plain values only: for JSON, TOML and the text chunks of pictures."""
    return {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}


@cache
def _hints(kind: type) -> dict[str, Any]:
    return typing.get_type_hints(kind)


def _kind(hint: Any) -> tuple[bool, Any]:
    """(may be None, the type itself) of an annotation such as ``float | None``."""
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        arms = [arm for arm in typing.get_args(hint) if arm is not type(None)]
        return True, arms[0]
    return False, hint


def _convert(name: str, value: Any, kind: Any, optional: bool) -> Any:
    if not isinstance(value, str) or kind is str:
        return value
    if optional and value.lower() in ("none", "auto", ""):
        return None
    if kind is bool:
        if value.lower() in ("true", "yes", "on", "1"):
            return True
        if value.lower() in ("false", "no", "off", "0"):
            return False
        raise SettingsError(f"{name}={value!r}: must be true or false")
    try:
        return kind(value)
    except ValueError:
        raise SettingsError(f"{name}={value!r}: must be a {'whole ' if kind is int else ''}number") from None
