"""Draws as data: what a pass draws, with which shader, from what. One executor interprets them.

Uniforms that every shader may declare (those of ``lib/view.glsl`` and ``lib/center_pixel.glsl``) are set by the executor and
stand in no record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import GraphError, near_miss

Define = str | int | float

VIEW_VALUES: Mapping[str, str] = {
    "far": "linear depth of the far plane, scene units",
    "pixel": "larger side of a pixel, scene units per unit of clip w",
    "pixel_smaller": "least distance that moves a point by a pixel, scene units per unit of clip w",
    "inverse_projection": "inverse of the projection, 4x4, column by column",
    "image_size": "(width, height) of the image, pixels",
    "image_texel": "1 / image_size",
    "image_share": "image_size of the whole over that of this part of it",
    "target_size": "(width, height) of the target, texels",
    "target_texel": "1 / target_size",
    "target_step": "pixels of the image to a texel of the target / image_size",
    "resource_size": "(width, height) of the texture of a resource, texels",
    "window_depth_far": "window depth of the far plane, 0 or 1",
    "window_depth_num": "numerator of linear depth, to be multiplied with (u, v, d - window_depth_far, 1)",
    "window_depth_den": "its denominator",
}
"""The closed list of what is known only with a camera and a size -> its meaning."""


@dataclass(frozen=True, slots=True)
class ViewValue:
    """A uniform that depends on the view: ``factor * value``, or ``1 / (factor * value)`` where it is ``inverse``.

    ``axis``: of a pair, 0 or 1; the other component is 0. ``resource``: whose size it is, for ``resource_size``.
    """

    name: str
    factor: float = 1.0
    inverse: bool = False
    axis: int | None = None
    resource: str = ""

    def __post_init__(self) -> None:
        if self.name not in VIEW_VALUES:
            raise GraphError(f"there is no view value '{self.name}'.{near_miss(self.name, VIEW_VALUES)}")
        object.__setattr__(self, "factor", float(self.factor))  # so that equal values have equal texts


@dataclass(frozen=True, slots=True)
class FloatTable:
    """An array of 32-bit floats as an immutable value. ``data``: its bytes, little-endian, last axis first."""

    shape: tuple[int, ...]
    data: bytes = field(repr=False)

    @classmethod
    def of(cls, values: ArrayLike) -> FloatTable:
        """Return the table of an array of any shape."""
        array = np.ascontiguousarray(values, "<f4")
        return cls(array.shape, array.tobytes())

    def array(self) -> NDArray[np.float32]:
        """Return the values as an array, which cannot be written."""
        return np.frombuffer(self.data, "<f4").reshape(self.shape)


Uniform = bool | int | float | tuple[float, ...] | FloatTable | ViewValue
"""Numbers, vectors and matrices (column by column), arrays, or what depends on the view."""


@dataclass(frozen=True, slots=True)
class Fullscreen:
    """One triangle over the target, by the fragment shader ``shader``.

    samplers: sampler uniform -> resource. tables: sampler uniform -> small repeating texture (h, w, channels). lit: uniforms that
    follow from where the camera and the lights of a scene stand; every frame brings their values.
    """

    shader: str
    samplers: Mapping[str, str] = field(default_factory=dict)
    uniforms: Mapping[str, Uniform] = field(default_factory=dict)
    tables: Mapping[str, FloatTable] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)
    lit: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DrawScene:
    """Everything in the frame's scene, nearest surface first. shaders: vertex and fragment shader, by kind of thing.

    clears: written resource -> what it holds where nothing is drawn. view: whose eye it is drawn from. without: names of things
    that are left out.
    """

    shaders: Mapping[str, tuple[str, str]]
    clears: Mapping[str, tuple[float, ...]]
    samplers: Mapping[str, str] = field(default_factory=dict)
    uniforms: Mapping[str, Uniform] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)
    view: str = "camera"
    without: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DrawElements:
    """The space around each element of the frame's scene, up to ``radius`` (scene units) from it, where the pixels within are.

    elements: "triangles", or "spheres": the scene's own, and those that stand for patches of its triangles. patch: the width of
    patches, scene units. shaders: vertex and fragment shader.
    """

    elements: Literal["triangles", "spheres"]
    shaders: tuple[str, str]
    radius: float
    patch: float = 0.0
    samplers: Mapping[str, str] = field(default_factory=dict)
    uniforms: Mapping[str, Uniform] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class HostWork:
    """What the host computes between two draws, for the part of the image that is wanted: one number a pixel.

    work: its name, by which the executor finds who does it. samplers: the resources that it reads. values: its settings.
    """

    work: str
    samplers: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, Define] = field(default_factory=dict)


Draw = Fullscreen | DrawScene | DrawElements | HostWork


def as_uniforms(values: Mapping[str, object]) -> dict[str, Uniform]:
    """Return uniforms as records hold them: arrays become tables, numpy's numbers become Python's. Raises GraphError."""
    return {name: _as_uniform(name, value) for name, value in values.items()}


def _as_uniform(name: str, value: object) -> Uniform:
    match value:
        case np.ndarray():
            return FloatTable.of(value)
        case np.generic():
            return value.item()  # type: ignore[no-any-return]
        case ViewValue() | FloatTable() | bool() | int() | float():
            return value
        case tuple() | list():
            return tuple(float(part) for part in value)
    raise GraphError(f"uniform '{name}' is a {type(value).__name__}; expected a number, a tuple, an array or a ViewValue")
