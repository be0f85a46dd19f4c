"""A scene as plain arrays: meshes, spheres and volumes with their transforms, and the cameras that came with them."""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from .baked_visibility import BakedVisibility
from .bounds import Drawable, box_corners, core_bounds, named_positions, placed_bounds, triangle_pieces
from .camera import Camera
from .lamps import Lamp
from .material import ColorTexture, Material, alpha_range
from .points import surfels
from .pose import look_at
from .projection import Size
from .spheres import Spheres
from .volume import Volume

DEFAULT_COLOR = (0.8, 0.8, 0.8)
"""sRGB, of what has no colour."""

RADIUS_SHARE = 0.03
"""Automatic AO radius as a share of the diagonal of a scene's bounding box."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles that are drawn once for each of their transforms.

    positions: (n, 3) float32, in scene units relative to ``transforms``. triangles: (m, 3) uint32. normals: (n, 3)
    float32 of any length, or None for flat shading. color: sRGB (r, g, b) in 0..1; the colour of ``material`` where there is
    one. It is multiplied with vertex_colors: (n, 4) uint8 sRGB with linear alpha, or None. transforms: (k, 4, 4)
    float64 model-to-world. uv: (n, 2) float32 coordinates in the material's texture, or None; (0, 0) is the upper left
    corner of the picture and v grows downwards, as in glTF. baked: visibility that it keeps, which the method ``baked`` shows.
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    normals: NDArray[np.float32] | None = None
    color: tuple[float, float, float] = DEFAULT_COLOR
    vertex_colors: NDArray[np.uint8] | None = None
    transforms: NDArray[np.float64] = field(default_factory=lambda: np.eye(4)[None])
    name: str = ""
    uv: NDArray[np.float32] | None = None
    material: Material | None = None
    baked: BakedVisibility | None = None

    def __post_init__(self) -> None:
        if self.material is not None:
            object.__setattr__(self, "color", self.material.color)
        where = f"mesh '{self.name}'" if self.name else "mesh"
        p, t = self.positions, self.triangles
        if p.ndim != 2 or p.shape[1] != 3 or t.ndim != 2 or t.shape[1] != 3:
            raise SceneError(f"{where}: positions must be (n, 3) and triangles (m, 3), got {p.shape} and {t.shape}")
        if len(t) and int(t.max()) >= len(p):
            raise SceneError(f"{where}: a triangle names vertex {int(t.max())}, but there are only {len(p)}")
        if not np.isfinite(p).all():
            raise SceneError(
                f"{where}: {int((~np.isfinite(p)).any(1).sum())} vertices are not finite numbers (NaN or infinity)"
            )
        for what, array, width in (
            ("normals", self.normals, 3), ("vertex_colors", self.vertex_colors, 4), ("uv", self.uv, 2)
        ):  # fmt: skip
            if array is not None and array.shape != (len(p), width):
                raise SceneError(f"{where}: {what} must be ({len(p)}, {width}), got {array.shape}")
        if self.baked is not None and self.baked.rows.shape != (len(p), *self.baked.width):
            raise SceneError(f"{where}: baked must have rows {(len(p), *self.baked.width)}, got {self.baked.rows.shape}")
        k = self.transforms
        if k.ndim != 3 or k.shape[1:] != (4, 4) or not np.isfinite(k).all():
            raise SceneError(f"{where}: transforms must be finite and (k, 4, 4), got {k.shape}")

    @classmethod
    def from_points(
        cls,
        positions: ArrayLike,
        colors: ArrayLike | None = None,
        radius: float | None = None,
        *,
        normals: ArrayLike | None = None,
        name: str = "",
    ) -> Mesh:
        """Make a mesh of points, as :meth:`Scene.from_points` describes. Raises SceneError."""
        made = surfels(positions, colors, radius, normals, f"points '{name}'" if name else "points")
        place = np.eye(4)
        place[:3, 3] = made.middle
        return cls(
            made.positions, made.triangles, made.normals, DEFAULT_COLOR if made.colors is None else (1.0, 1.0, 1.0),
            made.colors, place[None], name,
        )  # fmt: skip

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) smallest and largest world coordinate over all instances, of the vertices that triangles name."""
        return placed_bounds(self.outline(), self.transforms)

    @property
    def piece_count(self) -> int:
        """Triangles of one instance."""
        return len(self.triangles)

    def outline(self) -> NDArray[np.float32]:
        """Return the vertices (n, 3) that triangles name."""
        return named_positions(self)

    def pieces(self, matrix: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return boxes (n, 2, 3) and areas (n,) of the triangles of an instance."""
        return triangle_pieces(self, matrix)

    @property
    def texture(self) -> ColorTexture | None:
        """The picture of base colour; None without one, or without coordinates in it."""
        return None if self.material is None or self.uv is None else self.material.base_color_texture

    @cached_property
    def alpha_range(self) -> tuple[float, float]:
        """Bounds of alpha over the surface, in 0..1."""
        factor = 1.0 if self.material is None else self.material.base_color[3]
        ranges = [(factor, factor)]
        if self.texture is not None:
            ranges.append(self.texture.alpha_range)
        if self.vertex_colors is not None:
            ranges.append(alpha_range(self.vertex_colors[:, 3]))
        return math.prod(low for low, _ in ranges), math.prod(high for _, high in ranges)

    @property
    def cutoff(self) -> float | None:
        """Alpha below which there is no surface; None where alpha need not be looked at."""
        cutoff = None if self.material is None else self.material.cutoff
        return None if cutoff is None or self.alpha_range[0] >= cutoff else cutoff

    @property
    def is_placed(self) -> bool:
        """Whether it has triangles and a place."""
        return bool(len(self.triangles) and len(self.transforms))

    @property
    def can_show(self) -> bool:
        """Whether it is placed, and not cut out as a whole."""
        cutoff = self.cutoff
        return self.is_placed and (cutoff is None or self.alpha_range[1] >= cutoff)


@dataclass(frozen=True, eq=False)
class Scene:
    """Meshes, spheres, volumes, lamps and cameras in one world. ``up`` is the direction that automatic cameras take for upwards.

    background: sRGB (r, g, b, alpha) in 0..1 behind everything, where the source names one. warnings: what was dropped,
    guessed or converted on the way here, a line each.
    """

    meshes: Sequence[Mesh] = ()
    cameras: Sequence[Camera] = ()
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    name: str = ""
    background: tuple[float, float, float, float] | None = None
    warnings: tuple[str, ...] = ()
    spheres: Sequence[Spheres] = ()
    volumes: Sequence[Volume] = ()
    lamps: Sequence[Lamp] = ()

    def __post_init__(self) -> None:
        if not any(thing.is_placed for thing in self.things):
            raise SceneError(f"{self.name or 'the scene'} has nothing to draw")

    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        color: tuple[float, float, float] = DEFAULT_COLOR,
        up: tuple[float, float, float] = (0.0, 1.0, 0.0),
    ) -> Scene:
        """One mesh from arrays: positions (n, 3), triangles (m, 3), normals (n, 3) or None for flat shading."""
        draw = Mesh(
            np.asarray(positions, np.float32),
            _indices(triangles),
            None if normals is None else np.asarray(normals, np.float32),
            color,
        )
        return cls([draw], up=up)

    @classmethod
    def from_points(
        cls,
        positions: ArrayLike,
        colors: ArrayLike | None = None,
        radius: float | None = None,
        *,
        normals: ArrayLike | None = None,
        up: tuple[float, float, float] = (0.0, 1.0, 0.0),
    ) -> Scene:
        """Make a scene of points, drawn as small discs along the surface that they sample.

        positions: (n, 3); those that are not finite are left out. colors: (n, 3 or 4), uint8 or floats in 0..1, sRGB.
        radius: of each disc, scene units; None for one that closes the surface, from the distances between neighbours.
        normals: (n, 3), or None for those of planes through neighbours. Raises SceneError.
        """
        return cls([Mesh.from_points(positions, colors, radius, normals=normals)], up=up)

    @classmethod
    def load(cls, path: Any, *, crease: float = math.radians(40), up: str = "auto") -> Scene:
        """Read a scene file by :func:`ssao_gl.load_scene`. Deprecated."""
        warnings.warn("Scene.load will go in 0.3; use ssao_gl.load_scene", DeprecationWarning, stacklevel=2)
        # By name: scenes know nothing of the loaders, which make them.
        loading = importlib.import_module("ssao_gl.loaders.load")
        return cast(Scene, loading.load_scene(path, crease=crease, up=up))

    @property
    def draws(self) -> Sequence[Mesh]:
        """Return ``meshes``, by their name of 0.1. Deprecated."""
        warnings.warn("Scene.draws is called Scene.meshes now; the old name goes in 0.3", DeprecationWarning, stacklevel=2)
        return self.meshes

    @property
    def things(self) -> Sequence[Mesh | Spheres | Volume]:
        """All that it is made of: meshes, then spheres, then volumes."""
        return [*self.meshes, *self.spheres, *self.volumes]

    @cached_property
    def drawn(self) -> Sequence[Mesh | Spheres | Volume]:
        """Those things of which something may be seen."""
        return [thing for thing in self.things if thing.can_show]

    @property
    def _extended(self) -> list[Drawable]:
        """What has an extent: all that is drawn; where that is nothing, all that is placed."""
        return list(self.drawn) or [thing for thing in self.things if thing.is_placed]

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) smallest and largest world coordinate."""
        boxes = np.array([thing.bounds for thing in self._extended])
        return np.stack([boxes[:, 0].min(0), boxes[:, 1].max(0)])

    @property
    def extent(self) -> float:
        """Length of the diagonal of ``bounds``, scene units."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    @cached_property
    def core(self) -> NDArray[np.float64]:
        """(2, 3) the box without strays: tiny things far from all the rest. Automatic cameras and radii are made for it."""
        return core_bounds(self._extended, self.bounds)

    @property
    def triangles(self) -> int:
        """How many triangles are drawn, instances counted each."""
        return sum(thing.piece_count * len(thing.transforms) for thing in self.drawn if isinstance(thing, Mesh))

    @property
    def pieces(self) -> int:
        """How many triangles, spheres and volumes are drawn, instances counted each."""
        return sum(thing.piece_count * len(thing.transforms) for thing in self.drawn)

    @property
    def contents(self) -> str:
        """What is drawn, in words: how many triangles, spheres and volumes, instances counted each."""
        spheres = sum(thing.piece_count * len(thing.transforms) for thing in self.drawn if isinstance(thing, Spheres))
        told = [f"{self.triangles:,} triangles"] if self.meshes else []
        told += [f"{spheres:,} spheres"] if self.spheres else []
        return ", ".join([*told, *(volume.contents for volume in self.volumes)])

    def default_radius(self, share: float = RADIUS_SHARE) -> float:
        """Return a share of the scene's size, of its diagonal without strays, as AO radius; the default suits objects seen whole."""
        return share * float(np.linalg.norm(self.core[1] - self.core[0])) or 1.0

    def default_camera(
        self, size: Size = (4, 3), *, azimuth: float = 0.6, elevation: float = 0.45, yfov: float = 0.7
    ) -> Camera:
        """Return a perspective camera that shows the scene, without strays, from the front, side and above. Angles in radians."""
        up = np.asarray(self.up, np.float64) / np.linalg.norm(self.up)
        side = np.cross(up, [0, 0, 1] if abs(up[2]) < 0.9 else [0, -1, 0])
        side /= np.linalg.norm(side)
        front = np.cross(side, up)
        level = math.cos(azimuth) * front + math.sin(azimuth) * side
        direction = math.cos(elevation) * level + math.sin(elevation) * up
        low, high = self.core
        center = self.core.mean(0)
        # Of a scene without extent as much as 64-bit coordinates can tell there.
        half = max(float(np.linalg.norm(high - low)) / 2, 1e-12 * float(np.abs(center).max()), 1e-30)
        pose = look_at(direction, (0, 0, 0), up)  # about the origin: far from it, a unit is less than a float can tell
        # The distance at which every corner of the box is inside the frustum.
        local = (box_corners(low, high) - center) @ pose[:3, :3]
        tan_y = math.tan(yfov / 2)
        tan = np.array([tan_y * size[0] / size[1], tan_y])
        distance = float((np.abs(local[:, :2]) / tan + local[:, 2:]).max()) * 1.05 + 1e-3 * half
        pose[:3, 3] = center + direction * distance
        return Camera.perspective(yfov, max(distance - half, 1e-3 * half) * 0.5, (distance + half) * 1.5, pose)


def _indices(triangles: ArrayLike) -> NDArray[np.uint32]:
    array = np.asarray(triangles)
    if array.size and (array.min() < 0 or array.max() >= 2**32):
        raise SceneError(f"triangles name vertices from {array.min()} to {array.max()}; they must not be negative")
    return array.astype(np.uint32)
