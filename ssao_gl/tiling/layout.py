"""Pictures too large for one texture, cut into tiles: where they lie, how far they overlap, what each one's camera sees.

Coordinates are OpenGL's: pixels from the lower left. A tile is drawn with a halo of the pixels that its own pixels look at,
as far as the picture and what is drawn around it (the guard) go, so that what a tap or a filter finds beyond a tile's edge
is what it finds in the whole picture. Everything starts at multiples of the noise tile (and of 16), so the pattern of the
noise goes on from tile to tile.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..methods.base import Method
from ..pipeline.build import plan_render
from ..pipeline.residual import residual_reach
from ..pipeline.settings import Settings, guard_band
from ..scene.camera import Camera
from ..scene.lens import CropLens
from ..scene.model import Scene
from ..scene.projection import Size, ViewConstants

TILE_STEP = 16
"""Tiles and halos are multiples of this: of the noise tiles, and of what passes at a lower resolution group together."""

SMALLEST = 64
"""Smallest side of a tile, pixels."""

LARGEST_HALO = 4096
"""Of a wider reach the rest is left out, pixels."""

USUAL_LIMIT = 16384
"""Largest texture side of most drivers; for plans that are made without one."""

WHOLE_BYTES = 2 << 30
"""A picture whose targets take more is drawn in tiles by itself."""

TILE_BYTES = 1 << 29
"""What the targets of one tile may take."""


@dataclass(frozen=True, slots=True)
class PixelRect:
    """Pixels x .. x + w, y .. y + h."""

    x: int
    y: int
    w: int
    h: int

    @property
    def size(self) -> Size:
        return self.w, self.h


@dataclass(frozen=True, slots=True)
class Tile:
    """``inner`` is what the tile adds to the picture, ``outer`` what is drawn for it."""

    inner: PixelRect
    outer: PixelRect

    def camera(self, camera: Camera, whole: Size) -> Camera:
        """Return the camera that shows ``outer`` of a picture of the size ``whole``."""
        return dataclasses.replace(camera, lens=CropLens(camera.lens, whole, (self.outer.x, self.outer.y)))

    def crop(self, array: NDArray[Any]) -> NDArray[Any]:
        """Return the pixels of ``inner`` from an array (h, w, ...) of ``outer``, row 0 on top."""
        left = self.inner.x - self.outer.x
        top = (self.outer.y + self.outer.h) - (self.inner.y + self.inner.h)
        return array[top : top + self.inner.h, left : left + self.inner.w]


@dataclass(frozen=True, slots=True)
class Layout:
    """A picture of ``size`` in tiles of ``side`` (those at the right and at the top may be smaller) with a ``halo``."""

    size: Size
    side: Size
    halo: int
    wanted: int
    """The halo that nothing would be lost with; ``halo`` is less where the reach is very long."""
    guard: int = 0
    """Pixels that are drawn around the picture."""
    step: int = TILE_STEP
    """What is drawn starts at multiples of it, from the corner of the guard."""

    @property
    def columns(self) -> int:
        return -(-self.size[0] // self.side[0])

    @property
    def rows(self) -> int:
        return -(-self.size[1] // self.side[1])

    @property
    def outer(self) -> Size:
        """Size of the largest tile with its halo."""
        w, h = (max(high - low for _, _, low, high in self._cuts(axis)) for axis in (0, 1))
        return w, h

    def tiles(self) -> list[Tile]:
        """All tiles, row by row from the top."""
        return [
            Tile(PixelRect(x0, y0, x1 - x0, y1 - y0), PixelRect(u0, v0, u1 - u0, v1 - v0))
            for y0, y1, v0, v1 in reversed(self._cuts(1))
            for x0, x1, u0, u1 in self._cuts(0)
        ]

    def _cuts(self, axis: int) -> list[tuple[int, int, int, int]]:
        """Along one axis, for each tile: first and end pixel without and with the halo."""
        whole, side, guard = self.size[axis], self.side[axis], self.guard

        def start(low: int) -> int:
            return max((low - self.halo + guard) // self.step, 0) * self.step - guard

        ends = [(low, min(low + side, whole)) for low in range(0, whole, side)]
        return [(low, high, start(low), min(high + self.halo, whole + guard)) for low, high in ends]

    def describe(self) -> str:
        """In words, on one line."""
        cut = f" (cut: the reach is {self.wanted}; seams may show)" if self.halo < self.wanted else ""
        return (
            f"{self.columns}x{self.rows} tiles of {self.side[0]}x{self.side[1]} pixels,"
            f" a halo of {self.halo} to each side{cut}, at most {self.outer[0]}x{self.outer[1]} drawn at a time"
        )

    def table(self) -> dict[str, Any]:
        """As plain values, for JSON."""
        return {
            "count": self.columns * self.rows,
            "columns": self.columns,
            "rows": self.rows,
            "side": list(self.side),
            "halo": self.halo,
            "halo_wanted": self.wanted,
            "drawn": list(self.outer),
        }


def layout(
    scene: Scene,
    camera: Camera,
    size: Size,
    settings: Settings,
    aovs: Sequence[str],
    *,
    tile: int | None = None,
    limit: int = USUAL_LIMIT,
) -> Layout | None:
    """How a picture is cut, or None when it is drawn whole. The settings' radius must be settled.

    ``tile``: side of the tiles in pixels, rounded up to a multiple of 16 (and of the noise tile); without one a picture
    stays whole unless it is larger than ``limit``, the driver's largest texture side, or than ``WHOLE_BYTES``.
    Raises SettingsError for tiles below 64 pixels or too large for the driver.
    """
    limit //= settings.supersample
    if tile is not None and tile < SMALLEST:
        raise SettingsError(f"--tile {tile}: must be at least {SMALLEST} pixels")
    if tile is None and max(size) <= limit and plan_render(settings, size, aovs).bytes <= WHOLE_BYTES:
        return None
    step = _step(settings.method)
    looks = {"image", "visibility"} & set(aovs)  # the others are of each pixel alone
    wanted = _up(halo(scene, camera, size, settings), step) if looks else 0
    least = min(wanted, max(min(LARGEST_HALO, limit // 4) // step * step, step))
    if tile is None:
        side = _own_side(settings, size, aovs, least, step, limit)
    else:
        side = (_up(tile, step), _up(tile, step))
    made = Layout(size, side, least, wanted, guard_band(settings.method, size[1]) if looks else 0, step)
    if max(made.outer) > limit:
        most = (limit - 2 * least) // step * step - (step if made.guard % step else 0)
        raise SettingsError(
            f"--tile {tile}: with its halo a tile is {made.outer[0]}x{made.outer[1]} pixels, and this OpenGL draws at most"
            f" {limit} a side; use at most {most}"
        )
    return made


def _own_side(settings: Settings, size: Size, aovs: Sequence[str], halo: int, step: int, limit: int) -> Size:
    """Tiles of equal size, as large as ``TILE_BYTES`` allows, though no narrower than their halo."""
    bytes_a_pixel = plan_render(settings, (1024, 1024), aovs).bytes / 1024**2
    outer, edges = min(math.isqrt(int(TILE_BYTES / bytes_a_pixel)), limit), 2 * halo + step
    most = max(outer - edges, min(halo, limit - edges), SMALLEST, step) // step * step
    w, h = (_up(-(-side // -(-side // most)), step) for side in size)
    return w, h


def halo(scene: Scene, camera: Camera, size: Size, settings: Settings) -> int:
    """How far the value of a pixel can depend on others, in pixels: the reach of the method, then that of the filter.

    At a lower resolution both are rounded to its pixels.
    """
    method = settings.method
    taps = tap_reach(method, camera.view(size), nearest(scene, camera, size))
    # A filter without a width of its own takes the half of the noise tile.
    filtered = (settings.blur.radius or method.traits.noise_tile) if settings.blur else 0
    # Beyond both, the neighbours that upsampling and edges ask for; then the filter of rays, for what it corrects.
    reach = math.ceil(min(taps, 1e9)) + (2 * filtered + 4) * method.traits.scale + residual_reach(settings)
    shading = settings.shading
    return max(reach, math.ceil(shading.halo_width * size[1]) + 2 * TILE_STEP) if shading.halo else reach


def unguarded(settings: Settings) -> Settings:
    """Return the settings for a tile, whose halo is its guard band."""
    bare = settings.method.traits.unguarded
    return dataclasses.replace(settings, method=bare) if bare else settings


def tap_reach(method: Method, view: ViewConstants, nearest: float) -> float:
    """Return the longest way from a pixel to a tap, in pixels, on surfaces not nearer than ``nearest`` (linear depth).

    A radius in scene units is longest on the nearest surface, at the corner of the picture that lies farthest off the
    axis (a ball there is seen as an ellipse, longer by the length of the ray), to a point that is nearer still by the radius.
    The method's own clamp (``Traits.max_reach``) bounds it whatever the size of the picture.
    """
    radius, traits = method.radius, method.traits
    if traits.radius_unit == "pixels":
        return float(radius)
    if traits.radius_unit == "share of the image":
        return float(radius) * max(view.whole or view.size)
    if radius is None:
        raise SettingsError(f"{method.name}: its radius must be settled before tiles are")
    w = view.w1 * max(nearest - radius, 1e-3 * abs(nearest)) + view.w0
    pixels = 0.5 * np.linalg.norm(view.projection[:2, :2], axis=1) * np.asarray(view.size)
    longest = radius * pixels.max() * _slant(view) / w if w > 0 else math.inf
    return min(longest, math.inf if traits.max_reach is None else traits.max_reach) + 1  # taps are rounded to texel centres


def nearest(scene: Scene, camera: Camera, size: Size) -> float:
    """Smallest linear depth that can be seen: of the near plane, or of the nearest corner of the scene's bounding box."""
    corners = np.array([[x, y, z] for x in scene.bounds[:, 0] for y in scene.bounds[:, 1] for z in scene.bounds[:, 2]])
    depths = (camera.pose[:3, 3] - corners) @ np.linalg.inv(camera.pose)[2, :3]
    return max(float(depths.min()), camera.view(size).near)


def _slant(view: ViewConstants) -> float:
    """Length of the longest ray of the picture per unit of depth: 1 / the cosine of its angle to the view axis."""
    c = view.constants
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) @ np.reshape(c["u_ray"], (2, 2)) + np.asarray(c["u_ray0"])
    return float(np.sqrt(1 + (corners**2).sum(1)).max())


def _step(method: Method) -> int:
    """Return what tiles are multiples of: ``TILE_STEP``, and the period of the method's noise."""
    traits = method.traits
    return math.lcm(TILE_STEP, max(traits.noise_tile, 1) * traits.scale)


def _up(value: int, step: int) -> int:
    return -(-value // step) * step
