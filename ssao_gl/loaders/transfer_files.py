"""Transfer functions by name, and from TOML files."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import SceneError, encodable, near_miss, one_line
from ..io.atomic import why_unreadable
from ..scene.transfer import Transfer, TransferPoint

MAX_BYTES = 1 << 20
HEX = re.compile(r"#[0-9a-fA-F]{6}")
FIELDS = ("unit", "step", "relative", "points")
POINT = ("value", "opacity", "color")


def _ramp(name: str, *points: tuple[float, float, str]) -> Transfer:
    made = [TransferPoint(value, opacity, _rgb(color)) for value, opacity, color in points]
    return Transfer(made, relative=True, name=name)


def _rgb(color: str) -> tuple[float, float, float]:
    r, g, b = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return r, g, b


PRESETS: Mapping[str, Transfer] = {
    made.name: made
    for made in (
        _ramp("bone", (0.35, 0, "#b5703f"), (0.45, 0.15, "#c98d5c"), (0.55, 0.8, "#efe3c8"), (1, 1, "#fffdf5")),
        _ramp("tissue", (0.1, 0, "#8c3a2e"), (0.25, 0.1, "#b5573f"), (0.45, 0.4, "#d98a6c"), (1, 0.9, "#fff2dd")),
        _ramp("grey", (0.15, 0, "#404040"), (0.4, 0.3, "#8c8c8c"), (1, 1, "#ffffff")),
    )
}  # fmt: skip
"""Transfer functions over shares of the data's range."""


def load_transfer(spec: str) -> Transfer:
    """Return a transfer function by the name of a preset, or from a TOML file. Raises SceneError.

    The file has ``[[points]]`` with ``value``, ``opacity`` (0 to 1 over the unit length) and ``color`` ("#rrggbb"), by growing
    value; and may have ``unit`` (scene units; without it the shortest side of a voxel), ``step`` (voxels) and ``relative``
    (values are shares of the data's range).
    """
    if spec in PRESETS:
        return PRESETS[spec]
    path = Path(spec)
    if reason := why_unreadable(path):
        known = ", ".join(PRESETS)
        raise SceneError(
            f"transfer function {spec}: {reason}; expected a TOML file or one of {known}.{near_miss(spec, PRESETS)}"
        )
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"{path}: larger than {MAX_BYTES >> 20} MiB; not a transfer function")
    try:
        table = tomllib.loads(path.read_text("utf-8"))
        return _from_table(table, encodable(path.name))
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    except (ValueError, TypeError, RecursionError) as error:
        raise SceneError(f"{path}: not a transfer function ({one_line(error, 120)})") from None


def _from_table(table: Mapping[str, Any], name: str) -> Transfer:
    _check_names(table, FIELDS, "it")
    points = table.get("points")
    if not isinstance(points, list) or not points or not all(isinstance(point, dict) for point in points):
        raise SceneError("expected tables [[points]] with value, opacity and color")
    made = []
    for number, point in enumerate(points):
        where = f"point {number}"
        _check_names(point, POINT, where)
        color = point.get("color", "#cccccc")
        if not isinstance(color, str) or not HEX.fullmatch(color):
            raise SceneError(f"{where}: color={color!r}: must look like #rrggbb")
        made.append(TransferPoint(_number(point, "value", where), _number(point, "opacity", where), _rgb(color)))
    relative = table.get("relative", False)
    if not isinstance(relative, bool):
        raise SceneError(f"relative={relative!r}: must be true or false")
    unit = _number(table, "unit", "it") if "unit" in table else None
    return Transfer(made, unit, _number(table, "step", "it") if "step" in table else 0.5, relative, name)


def _check_names(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for name in table:
        if name not in known:
            raise SceneError(f"{where} has no '{name}'; there are {', '.join(known)}.{near_miss(name, known)}")


def _number(table: Mapping[str, Any], name: str, where: str) -> float:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SceneError(f"{where}: {name}={value!r}: must be a number")
    return float(value)
