"""Texture coordinates for what has none that could be used: an atlas of charts, by the package xatlas, which is an extra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, SettingsError, one_line
from ..truth.rays import RayScene
from .primitives import Primitive

F32 = NDArray[np.float32]
TRIES = 3
"""xatlas only estimates how large a texel may be for all charts to fit."""
FITS = 1.05
"""Times the texture's size that an atlas may be, and is shrunk from."""


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A primitive whose vertices are split along the seams of its charts.

    source: (n,) the old vertex of each new one. faces: (m, 3) in the new ones, in the same order. uv: (n, 2), v downwards.
    """

    source: NDArray[np.int64]
    faces: NDArray[np.int64]
    uv: F32


def unwrap(rays: RayScene, primitives: Sequence[Primitive], size: int, padding: int) -> list[Unwrapped]:
    """Put all primitives into one square texture, as large as they are where their first instances stand.

    padding: texels between charts. Raises SettingsError without xatlas.
    """
    library = _xatlas()
    asked = float(size)
    for _ in range(TRIES):
        atlas = library.Atlas()
        for primitive in primitives:
            _add(atlas, rays, primitive)
        options = library.PackOptions()
        options.resolution, options.padding, options.bilinear = max(round(asked), 1), padding, True
        atlas.generate(library.ChartOptions(), options)
        larger = max(atlas.width, atlas.height) / size
        if larger <= FITS or asked <= 1:
            break
        asked /= larger
    if atlas.atlas_count != 1:
        raise SceneError(f"does not fit into one texture of {size} texels with {padding} between charts; use a larger one")
    return [_unwrapped(*atlas[number]) for number in range(len(primitives))]


def _add(atlas: Any, rays: RayScene, primitive: Primitive) -> None:
    faces = primitive.faces
    positions = np.zeros((primitive.vertices, 3), np.float32)
    corners, _ = rays.corners(primitive.parts[0], np.arange(len(faces), dtype=np.int32))
    positions[faces.ravel()] = corners.reshape(-1, 3)
    try:
        atlas.add_mesh(positions, faces.astype(np.uint32))
    except (RuntimeError, ValueError) as error:
        raise SceneError(f"mesh '{primitive.name}': xatlas cannot unwrap it ({one_line(error, 100)})") from None


def _unwrapped(source: NDArray[Any], faces: NDArray[Any], uv: NDArray[Any]) -> Unwrapped:
    return Unwrapped(source.astype(np.int64), faces.astype(np.int64).reshape(-1, 3), np.clip(uv, 0, 1).astype(np.float32))


def _xatlas() -> Any:
    try:
        import xatlas
    except ImportError:
        raise SettingsError(
            "a mesh has no texture coordinates that could be used, and making some needs the package xatlas:"
            " pip install 'ssao_gl[bake]', or bake to vertices"
        ) from None
    return xatlas
