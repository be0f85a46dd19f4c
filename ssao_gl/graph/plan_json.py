"""Plans as JSON: what a frame is made of, for files, for comparison and for executors elsewhere.

Records become objects of their fields; what may be one of several records carries its ``kind``. Tables are their shape and
their bytes (32-bit floats, little-endian, last axis first) in base 64. ``plan == plan_from_json(plan_to_json(plan))``.
"""

from __future__ import annotations

import base64
import binascii
import dataclasses
import json
import types
import typing
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal

from ..errors import GraphError, one_line
from .declare import DepthTest, Pass, Texture
from .draws import DrawElements, DrawScene, FloatTable, Fullscreen, HostWork, ViewValue
from .plan import Plan, PlannedPass, Slot

FORMAT = "ssao_gl plan 1"
RECORDS = {kind.__name__: kind for kind in (Fullscreen, DrawScene, DrawElements, HostWork, FloatTable, ViewValue)}
"""Records that stand where others could, by their kind."""
FIXED = (Plan, PlannedPass, Pass, Slot, Texture, DepthTest)
"""Records whose place tells what they are."""


def plan_to_json(plan: Plan) -> str:
    """Return a plan as JSON text."""
    return json.dumps({"format": FORMAT, "plan": _encoded(plan)}, indent=1, allow_nan=False)


def plan_from_json(text: str) -> Plan:
    """Return the plan of a text that :func:`plan_to_json` made. Raises GraphError for any other."""
    try:
        content = json.loads(text)
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"'format' is not '{FORMAT}'")
        plan: Plan = _decoded(Plan, content["plan"])
        return plan
    except (ValueError, KeyError, TypeError, RecursionError, binascii.Error) as error:
        raise GraphError(f"not a plan as JSON: {type(error).__name__}: {one_line(error, 200)}") from None


def _encoded(value: Any) -> Any:
    match value:
        case FloatTable(shape, data):
            return {"kind": "FloatTable", "shape": list(shape), "data": base64.b64encode(data).decode()}
        case Mapping():
            return {key: _encoded(item) for key, item in value.items()}
        case tuple() | list():
            return [_encoded(item) for item in value]
    if not dataclasses.is_dataclass(value):
        return value
    fields = {field.name: _encoded(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return fields if isinstance(value, FIXED) else {"kind": type(value).__name__, **fields}


def _decoded(kind: Any, value: Any) -> Any:
    """Return the value of a field of that type."""
    if dataclasses.is_dataclass(kind):
        return _record(kind, value)
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return _one_of(arguments, value)
    if origin is Literal:
        if value not in arguments:
            raise ValueError(f"{value!r} is none of {', '.join(map(str, arguments))}")
        return value
    if origin is tuple:
        inner = arguments if arguments[-1] is not Ellipsis else (arguments[0],) * len(value)
        return tuple(_decoded(part, item) for part, item in zip(inner, value, strict=True))
    if origin is not None:  # a mapping from names
        return {str(key): _decoded(arguments[1], item) for key, item in value.items()}
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind):
        raise TypeError(f"{value!r} is no {kind.__name__}")
    return value


def _record(kind: Any, value: Any) -> Any:
    if kind is FloatTable:
        return FloatTable(tuple(map(int, value["shape"])), base64.b64decode(value["data"], validate=True))
    hints = _hints(kind)
    fields = {key: item for key, item in value.items() if key != "kind"}
    if set(fields) != set(hints):
        raise ValueError(f"{kind.__name__} has the fields {', '.join(hints)}, not {', '.join(fields)}")
    return kind(**{key: _decoded(hints[key], item) for key, item in fields.items()})


def _one_of(kinds: tuple[Any, ...], value: Any) -> Any:
    """Return a value of the one type among several that it has."""
    if value is None and type(None) in kinds:
        return None
    if isinstance(value, dict) and "kind" in value:
        return _record(RECORDS[value["kind"]], value)
    for kind in kinds:
        if isinstance(value, list) and typing.get_origin(kind) is tuple:
            return _decoded(kind, value)
        if dataclasses.is_dataclass(kind) and isinstance(value, dict) and kind not in RECORDS.values():
            return _record(kind, value)
        if kind in (bool, int, float, str) and type(value) is kind:
            return value
    raise TypeError(f"{value!r} is none of {', '.join(str(kind) for kind in kinds)}")


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return typing.get_type_hints(kind)
