"""``ssao-gl methods``: what can be set of methods, filters and the rest of a picture."""

from __future__ import annotations

import dataclasses
import json as json_module
import math
from collections.abc import Mapping
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import SettingsError, near_miss
from ..methods.registry import presets_of, registry
from ..passes.denoise import FILTERS
from ..pipeline.settings import Settings, Shading
from ..settings import limits
from .output import print_table, say


def methods(
    name: str | None = None,
    *,
    json: Annotated[bool, Parameter(name="--json", negative="", help="As JSON.")] = False,
) -> int:
    """List the AO methods and filters with their settings, units, ranges and defaults.

    Parameters
    ----------
    name
        Only this one.
    """
    kinds = _kinds()
    if name is not None:
        chosen = {key: kind for key, kind in kinds.items() if name in (key, key.removeprefix("blur "))}
        if not chosen:
            raise SettingsError(f"unknown method or filter '{name}'; there are {', '.join(kinds)}.{near_miss(name, kinds)}")
        kinds = chosen
    if json:
        say(json_module.dumps({key: _table(key, kind) for key, kind in kinds.items()}, indent=1))
        return 0
    for key, kind in kinds.items():
        _tell(_table(key, kind))
    return 0


def _kinds() -> Mapping[str, Any]:
    """Return everything that has settings, by the name that help calls it."""
    return {**registry(), **{f"blur {key}": kind for key, kind in FILTERS.items()}, "shading": Shading, "picture": Settings}


def _table(key: str, kind: Any) -> dict[str, Any]:
    """Return what is known of a settings record, as plain values."""
    fields = [field for field in dataclasses.fields(kind) if "limits" in field.metadata]
    return {
        "name": key,
        "about": " ".join((kind.__doc__ or "").strip().split("\n\n")[0].split()),
        "set": {"picture": "KEY"}.get(key, f"{key.split()[0]}.KEY" if key not in registry() else "KEY"),
        "settings": [
            {
                "name": field.name,
                "default": field.default,
                "unit": limits(field).unit,
                "range": limits(field).describe(),
                "about": limits(field).doc,
            }
            for field in fields
        ],
        "presets": {name: dict(values) for name, values in presets_of(key).items()},
        "deviations": {
            contract: {"bound": one.bound if math.isfinite(one.bound) else None, "why": one.reason}
            for contract, one in (registry()[key].exceptions if key in registry() else {}).items()
        },
    }


def _tell(about: Mapping[str, Any]) -> None:
    """Print it."""
    say(f"{about['name']}: {about['about']}  (--set {about['set']}=VALUE)")
    rows = [(one["name"], _shown(one["default"]), one["unit"], one["range"], one["about"]) for one in about["settings"]]
    print_table("", ("setting", "default", "unit", "range", "what it is"), rows)
    for name, values in about["presets"].items():
        say(f"  --preset {name}: {', '.join(f'{key}={value}' for key, value in values.items()) or 'as shipped'}")
    for contract, one in about["deviations"].items():
        say(f"  by its definition it breaks '{contract}' ({_bounded(one['bound'])}): {one['why']}")


def _bounded(bound: float | None) -> str:
    return "it refuses" if bound is None else f"bound {bound:g}"


def _shown(value: object) -> str:
    return "auto" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
