"""Uniform values of an exported pipeline: numbers, or formulas over the view and over settings that stay open.

A value is a number, a list of components (matrices column by column), or a record:

* ``{"view": NAME}`` is one of :data:`VIEW_FORMULAS`; with ``factor`` times that; with ``inverse`` one over the product; with
  ``axis`` only that component of a pair, the other 0; with ``resource`` of that resource.
* ``{"setting": NAME, "factor": F}`` is ``F * setting``; with ``inverse`` ``1 / (F * setting)``; with ``part`` of that component of it.

A ``factor`` is a number or a record of a setting.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import GraphError
from ..graph.draws import VIEW_VALUES, FloatTable, Uniform, ViewValue
from ..graph.plan import PlannedPass

Formula = Any
"""A value as JSON holds it."""

VIEW_FORMULAS: Mapping[str, str] = {
    **{name: meaning for name, meaning in VIEW_VALUES.items() if name != "pixel_smaller"},  # for scenes known to be whole
    "ray": "2x2, column by column: view xy = (ray uv + ray0) z + (org uv + org0) at linear depth z",
    "ray0": "(x, y) of the same",
    "org": "2x2 of the same",
    "org0": "(x, y) of the same",
    "clip_w": "(a, b): clip w = a z + b",
    "uv_per_unit": "2x2: uv moved by an offset in scene units parallel to the image, times clip w",
}
"""The closed list of what depends on the projection and the size -> its meaning."""

STANDARD: Mapping[str, Formula] = {
    "u_size": {"view": "image_size"},
    "u_texel": {"view": "image_texel"},
    "u_ray": {"view": "ray"},
    "u_ray0": {"view": "ray0"},
    "u_org": {"view": "org"},
    "u_org0": {"view": "org0"},
    "u_w": {"view": "clip_w"},
    "u_uv_per_unit": {"view": "uv_per_unit"},
    "u_target_texel": {"view": "target_texel"},
    "u_target_uv": {"view": "target_step"},
}
"""Uniforms that every shader may declare -> their value, the same formula in every pass."""


def scale_formulas(step: PlannedPass) -> dict[str, Formula]:
    """Return the values of the uniforms that every shader may declare and that each pass has its own of."""
    return {"u_scale": number(step.scale), "u_test_depth": 1 if step.task.test and step.task.test.far else 0}


def number(value: float) -> float | int:
    """Return a number as its shortest text that gives the same 32-bit float."""
    short = float(str(np.float32(value)))
    return int(short) if short.is_integer() and abs(short) < 1e9 else short


def components(value: Uniform) -> list[float]:
    """Return the numbers in a uniform's value, of a view value its factor."""
    match value:
        case ViewValue():
            return [value.factor]
        case FloatTable():
            return [float(part) for part in value.array().ravel()]
        case tuple():
            return list(value)
    return [float(value)]


def formula(value: Uniform, open_parts: Mapping[int, Formula]) -> Formula:
    """Return a value as JSON has it. ``open_parts``: number of a component -> the record of a setting that stands for it."""
    if isinstance(value, ViewValue):
        return _view_formula(value, open_parts.get(0, value.factor))
    parts = [open_parts.get(index, number(part)) for index, part in enumerate(components(value))]
    return parts if isinstance(value, tuple | FloatTable) else parts[0]


def _view_formula(value: ViewValue, factor: Formula) -> Formula:
    if value.name not in VIEW_FORMULAS:
        raise GraphError(f"the view value '{value.name}' has no formula outside Python")
    more = {"factor": factor, "inverse": value.inverse, "axis": value.axis, "resource": value.resource}
    usual = {"factor": 1.0, "inverse": False, "axis": None, "resource": ""}
    return {"view": value.name} | {key: item for key, item in more.items() if item != usual[key]}
