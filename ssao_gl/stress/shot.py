"""One picture to be drawn, and what came of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size

RADIUS = 0.8
"""Reach of occlusion in the little scenes of the cases, which are some 5 units away and as large."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A scene, or a depth image, before a camera.

    depth: (h, w) numbers of ``kind`` ("eye": scene units, "window": 0..1), row 0 on top. normals: (h, w, 3) in view space,
    or None. radius: in scene units, for methods whose radius is a length; None: automatic. blur: name of a filter.
    changes: fields of the method to set, where it has them. normals_of: which normals of a scene count. keep: what is not
    left out where the scene does not need it (see ``Settings``).
    """

    camera: Camera
    scene: Scene | None = None
    size: Size | None = None
    depth: NDArray[Any] | None = None
    normals: NDArray[Any] | None = None
    kind: str = "eye"
    radius: float | None = RADIUS
    blur: str = "none"
    changes: Mapping[str, Any] = field(default_factory=dict)
    normals_of: str = "geometric"
    keep: tuple[str, ...] = ()

    def but(self, **changes: Any) -> Shot:
        """Return this shot with some fields replaced."""
        return dataclasses.replace(self, **changes)


@dataclass(frozen=True, eq=False)
class Capture:
    """visibility: (h, w) float32. depth: (h, w) float32, linear, 0 = background. normal: (h, w, 3) float32."""

    visibility: NDArray[np.float32]
    depth: NDArray[np.float32]
    normal: NDArray[np.float32]

    @property
    def surface(self) -> NDArray[np.bool_]:
        """Where something is seen."""
        return self.depth > 0

    @property
    def darkest(self) -> float:
        """How far the darkest pixel is from open."""
        return 1 - float(self.visibility.min())

    @property
    def mean(self) -> float:
        """Mean visibility of what is seen; 1 where nothing is."""
        return float(self.visibility[self.surface].mean(dtype=np.float64)) if self.surface.any() else 1.0


def share(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Share of the pixels whose visibilities differ by more than one step of 8 bits."""
    return float((np.abs(a.astype(np.float64) - b) > 1 / 255 + 1e-6).mean())


def apart(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Mean absolute difference of two visibilities."""
    return float(np.abs(a.astype(np.float64) - b).mean())
