"""Texture coordinates for what has none that could be used: an atlas of charts, by the package xatlas, which is an extra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, SettingsError, one_line
from ..loaders.notes import Notes
from .facets import Facets
from .primitives import Primitive

F32 = NDArray[np.float32]
TRIES, SMALLER = 12, 1.01
"""How often charts are packed, smaller each time, until they fit: xatlas only estimates how large they may be."""
LARGEST = 1 / 64
"""Of a chart, as a share of the whole area: xatlas takes minutes to grow few large ones over a smooth scan."""


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A primitive whose vertices are split along the seams of its charts.

    source: (n,) the old vertex of each new one. faces: (m, 3) in the new ones, in the same order. uv: (n, 2), v downwards.
    """

    source: NDArray[np.int64]
    faces: NDArray[np.int64]
    uv: F32


def unwrap(facets: Facets, primitives: Sequence[Primitive], size: int, padding: int, notes: Notes) -> list[Unwrapped]:
    """Put all primitives into one square texture, as large as they are where their first instances stand.

    padding: texels between charts; less where many charts leave no room, which is noted. Raises SettingsError without xatlas,
    SceneError for more charts than fit.
    """
    library = _xatlas()
    charts = library.Atlas()
    for primitive in primitives:
        _add(charts, facets, primitive)
    options = library.ChartOptions()
    options.max_chart_area = (
        sum(float(facets.areas(primitive.parts[0], len(primitive.faces)).sum()) for primitive in primitives) * LARGEST
    )
    charts.generate(options, _packing(library, size, padding))
    if not charts.chart_count:
        raise SceneError("none of its triangles has an area, so there is nothing to make a texture for")
    found = [charts[number] for number in range(len(primitives))]
    sides = np.array([charts.width, charts.height])
    packed, left = _packed(library, [(uv * sides, faces) for _, faces, uv in found], size, padding)
    if left < padding:
        notes.add(
            f"its {charts.chart_count} charts leave room for a padding of {left} texels, not {padding}; use a larger texture"
        )
    return [
        Unwrapped(source[again].astype(np.int64), faces.astype(np.int64).reshape(-1, 3), uv)
        for (source, _, _), (again, faces, uv) in zip(found, packed, strict=True)
    ]


def _packed(
    library: Any, charts: list[tuple[NDArray[Any], NDArray[Any]]], size: int, padding: int
) -> tuple[list[tuple[NDArray[Any], NDArray[Any], F32]], int]:
    """Pack charts (uv in texels, faces) into a square, as large as they fit: vertices, faces, uv of each mesh, and the padding."""
    while True:
        options = _packing(library, 0, padding)
        options.texels_per_unit = SMALLER * size / max(float(uv.max(initial=1)) for uv, _ in charts)
        for _ in range(TRIES):
            atlas = library.Atlas()
            for uv, faces in charts:
                atlas.add_uv_mesh(uv.astype(np.float32), faces.astype(np.uint32))
            atlas.generate(library.ChartOptions(), options)
            sides = np.array([atlas.width, atlas.height]) / size
            if sides.max() <= 1 and atlas.atlas_count == 1:
                every = (atlas[number] for number in range(len(charts)))
                return [(v, f, np.clip(uv * sides, 0, 1).astype(np.float32)) for v, f, uv in every], padding
            options.texels_per_unit /= max(sides.max(), SMALLER)
        if not padding:
            raise SceneError(f"has {atlas.chart_count} charts, too many for {size} x {size} texels; use a larger texture")
        padding //= 2


def _packing(library: Any, size: int, padding: int) -> Any:
    """Return options of xatlas, which pads every chart on all sides."""
    options = library.PackOptions()
    options.resolution, options.padding, options.bilinear = size, -(-padding // 2), False
    return options


def _add(atlas: Any, facets: Facets, primitive: Primitive) -> None:
    faces = primitive.faces
    positions = np.zeros((primitive.vertices, 3), np.float32)
    corners, _ = facets.rays.triangles.corners(primitive.parts[0], np.arange(len(faces), dtype=np.int32))
    positions[faces.ravel()] = corners.reshape(-1, 3)
    try:
        atlas.add_mesh(positions, faces.astype(np.uint32))
    except (RuntimeError, ValueError) as error:
        raise SceneError(f"mesh '{primitive.name}': xatlas cannot unwrap it ({one_line(error, 100)})") from None


def _xatlas() -> Any:
    try:
        import xatlas
    except ImportError:
        raise SettingsError(
            "a mesh has no texture coordinates that could be used, and making some needs the package xatlas:"
            " pip install 'ssao_gl[bake]', or bake to vertices"
        ) from None
    return xatlas
