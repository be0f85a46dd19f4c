"""What every kind of thing in a scene is drawn with: the view, the targets, and the uniforms that all their shaders share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..glsl.preprocess import Define
from ..graph.draws import DrawScene
from ..graph.names import (
    BAKED,
    CASTER_DEPTH,
    COLOR,
    DEPTH,
    DEPTH_LAYER_2,
    LABELS,
    MATERIAL,
    NORMAL,
    RECEIVER_DEPTH,
    SHADING_NORMAL,
    SHADOW_COLOR,
    SHADOW_DEPTH,
    SHADOW_NORMAL,
)
from ..scene.labels import Label, is_called
from ..scene.projection import Matrix, ViewConstants

TARGETS = {
    DEPTH: "DEPTH_TARGET",
    DEPTH_LAYER_2: "DEPTH_TARGET",
    CASTER_DEPTH: "DEPTH_TARGET",
    RECEIVER_DEPTH: "DEPTH_TARGET",
    NORMAL: "NORMAL_TARGET",
    SHADING_NORMAL: "SHADING_NORMAL_TARGET",
    COLOR: "COLOR",
    BAKED: "BAKED_TARGET",
    MATERIAL: "MATERIAL_TARGET",
    SHADOW_DEPTH: "DEPTH_TARGET",
    SHADOW_NORMAL: "NORMAL_TARGET",
    SHADOW_COLOR: "COLOR",
    LABELS: "LABELS_TARGET",
}
"""Resource -> the define that makes the shader write it."""
AS_SEEN = {SHADOW_NORMAL: NORMAL, SHADOW_COLOR: COLOR}
"""What a light is shown -> the same for the camera."""

_Kind = tuple[tuple[str, str], tuple[str, ...], tuple[tuple[str, Define], ...]]


@dataclass(frozen=True, slots=True, eq=False)
class SceneDraw:
    """One draw of a scene, as its things see it.

    writes: the targets, in order. defines, uniforms: of every shader. from_center: (4, 4) float64, from the world's axes about
    the middle of the scene to view space; projection: from there to the clip space of the fitted depth range.
    drawn_depth: reads the linear depth (h, w) that the target holds already, 0 where nothing is drawn, row 0 at the bottom; None
    where depth is not drawn. labels: of things by their ``id()``, where they are drawn.
    """

    draw: DrawScene
    writes: tuple[str, ...]
    defines: Mapping[str, Define]
    uniforms: Mapping[str, Any]
    view: ViewConstants
    from_center: Matrix
    projection: Matrix
    drawn_depth: Callable[[], NDArray[np.float32]] | None = None
    labels: Mapping[int, Label] = field(default_factory=dict)

    def leaves_out(self, thing: Any) -> bool:
        """Return whether this draw is without a thing."""
        return bool(self.draw.without) and is_called(thing, self.draw.without)

    def label(self, thing: Any) -> dict[str, Label]:
        """Return the uniform of a thing's numbers, where they are drawn."""
        return {"u_label": self.labels[id(thing)]} if self.labels else {}

    @property
    def first_unit(self) -> int:
        """The first texture unit that is free."""
        return len(self.draw.samplers)

    def program_key(self, kind: str) -> _Kind:
        """Return what decides the program of a kind of thing, but the thing itself: shader, targets, defines."""
        return self.draw.shaders[kind], self.writes, tuple(sorted(self.defines.items()))

    @property
    def shown(self) -> frozenset[str]:
        """What of surfaces the targets hold, by the names of the camera's."""
        return frozenset(AS_SEEN.get(name, name) for name in self.writes)

    @property
    def target_defines(self) -> dict[str, int]:
        """Which targets there are, and where."""
        return {"TARGETS": len(self.writes)} | {TARGETS[name]: index for index, name in enumerate(self.writes)}


class ThingBuffers(Protocol):
    """The things of one kind in GL objects."""

    def draw(self, seen: SceneDraw) -> None:
        """Draw them into the bound framebuffer."""

    def release(self) -> None:
        """Free every GL object of these."""
