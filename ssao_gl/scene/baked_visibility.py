"""Visibility that a mesh keeps, at its vertices or in a texture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .material import ColorTexture, Wrap


@dataclass(frozen=True, eq=False)
class BakedTexture:
    """A picture whose red channel is visibility, as numbers and not as sRGB. ``unpack`` makes it; nobody may ever want it."""

    unpack: Callable[[], NDArray[np.uint8]]
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    nearest: bool = False
    mipmaps: bool = True
    name: str = ""

    @cached_property
    def picture(self) -> ColorTexture:
        """The picture itself. Raises SceneError for what cannot be unpacked."""
        return ColorTexture(self.unpack(), self.wrap, self.nearest, self.mipmaps, self.name, linear=True)


@dataclass(frozen=True, eq=False)
class BakedVisibility:
    """What a mesh of n vertices keeps.

    rows: (n,) visibility in 0..1; with a texture (n, 2) coordinates in it, v downwards. strength: of the texture, 0 (all open)
    to 1. base_color: linear (r, g, b) of the surface where its vertex colours are this visibility and nothing else, so that they must
    not darken it twice.
    """

    rows: NDArray[np.float32]
    texture: BakedTexture | None = None
    strength: float = 1.0
    base_color: tuple[float, float, float] | None = None

    @property
    def width(self) -> tuple[int, ...]:
        """Shape of a row."""
        return () if self.texture is None else (2,)

    def picked(self, vertices: NDArray[Any]) -> BakedVisibility:
        """Return it for other vertices: indices (k,) of old ones, or which are kept (n,)."""
        return replace(self, rows=self.rows[vertices])
