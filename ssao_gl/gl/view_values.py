"""What draws leave open until there is a view: the values of :data:`ssao_gl.graph.draws.VIEW_VALUES`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import ViewValue
from ..graph.plan import PlannedPass
from ..scene.projection import Size, ViewConstants

Value = float | tuple[float, ...]


def view_value(wanted: ViewValue, view: ViewConstants, step: PlannedPass, resource_size: Callable[[str], Size]) -> Value:
    """Return the number, vector or matrix (column by column) of a uniform that depends on the view.

    ``resource_size``: gives (width, height) of a resource's texture.
    """
    if wanted.name == "image_share":
        pairs = zip(view.whole or view.size, view.size, strict=True)
        return tuple(wanted.factor * whole / side for whole, side in pairs)
    value = resource_size(wanted.resource) if wanted.name == "resource_size" else _VALUES[wanted.name](view, step)
    if isinstance(value, tuple):
        scaled = tuple(_scaled(part, wanted) for part in value)
        return scaled if wanted.axis is None else tuple(v if i == wanted.axis else 0.0 for i, v in enumerate(scaled))
    return _scaled(value, wanted)


def _scaled(value: float, wanted: ViewValue) -> float:
    return 1 / (wanted.factor * value) if wanted.inverse else wanted.factor * value


def _pixel_smaller(view: ViewConstants) -> float:
    steps = 2 * np.linalg.inv(view.projection[:2, :2]) / np.asarray(view.size)
    return float(np.linalg.svd(steps, compute_uv=False).min())


def _inverse_projection(view: ViewConstants) -> tuple[float, ...]:
    return tuple(np.linalg.inv(view.projection).T.ravel())


_VALUES: Mapping[str, Callable[[ViewConstants, PlannedPass], Any]] = {
    "far": lambda view, step: view.far,
    "pixel": lambda view, step: view.pixel,
    "pixel_smaller": lambda view, step: _pixel_smaller(view),
    "inverse_projection": lambda view, step: _inverse_projection(view),
    "image_size": lambda view, step: view.size,
    "image_texel": lambda view, step: view.constants["u_texel"],
    "target_size": lambda view, step: step.size,
    "target_texel": lambda view, step: (1 / step.size[0], 1 / step.size[1]),
    "target_step": lambda view, step: (step.scale / view.size[0], step.scale / view.size[1]),
    "window_depth_far": lambda view, step: view.depth_constants["u_depth_far"],
    "window_depth_num": lambda view, step: view.depth_constants["u_depth_num"],
    "window_depth_den": lambda view, step: view.depth_constants["u_depth_den"],
}


def onto_target(view: ViewConstants, step: PlannedPass) -> NDArray[np.float64]:
    """Return the matrix (4, 4) that brings clip coordinates of the image to those of the target.

    A texel of several pixels shows what the middle of one of them does, so that it is free of what lies beside.
    """
    scale, matrix = step.scale, np.eye(4)
    middle = 0.5 - (scale // 2 + 0.5) / scale  # of that pixel in the texel's units, from the texel's
    for axis in (0, 1):
        share = view.size[axis] / (scale * step.size[axis])
        matrix[axis, axis], matrix[axis, 3] = share, share - 1 + 2 * middle / step.size[axis]
    return matrix


def target_constants(view: ViewConstants, step: PlannedPass) -> dict[str, Value]:
    """Return the uniforms of ``lib/center_pixel.glsl``. A fragment of a smaller target stands for ``scale`` by ``scale`` pixels."""
    (w, h), scale = view.size, step.scale
    return {
        "u_target_texel": (1 / step.size[0], 1 / step.size[1]),
        "u_target_uv": (scale / w, scale / h),
        "u_scale": float(scale),
        "u_test_depth": 1.0 if step.task.test and step.task.test.far else 0.0,
    }
