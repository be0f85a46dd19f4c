"""Light of one bounce, gathered beside occlusion for the same pixels and filtered with it: the lecture's two ways, to compare."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..graph.declare import DepthTest, Pass
from ..graph.draws import Define, FloatTable, Fullscreen, Uniform, ViewValue
from ..graph.names import (
    BOUNCE,
    DEPTH,
    GAINED,
    NORMAL,
    PIXEL_DEPTH,
    PIXEL_NORMAL,
    SHADOW_COLOR,
    SHADOW_DEPTH,
    SHADOW_NORMAL,
    VISIBILITY,
    VISIBILITY_RAW,
)  # fmt: skip
from ..sampling.disk import Kernel, Rotation, radical_inverse
from .extra_signals import extra_signals
from .occlusion import PIXEL

ANY = 1e6
"""Pixels of a footprint that is as large as it is."""


@dataclass(frozen=True, slots=True)
class Gathering:
    """What is asked of a gathering pass. radius: scene units. most: largest footprint, pixels, 0: any. tile: width of the noise, texels.

    filtered: whether it is averaged away. packed, scale, test: as occlusion has them, see :func:`ssao_gl.passes.occlusion.occlude`.
    """

    taps: int
    radius: float
    most: float
    tile: int
    filtered: bool
    packed: bool
    scale: int
    test: DepthTest | None

    @property
    def uniforms(self) -> dict[str, Uniform]:
        """What both ways go by."""
        # Along creases, where it matters, the filter is half as wide as the tile.
        own = min(4 / self.tile**2, 1.0) if self.filtered else 1.0
        return {"u_radius": self.radius, "u_noise_width": float(self.tile), "u_own": own}


def from_shadow_map(job: Gathering) -> Pass:
    """Gather what the texels of a shadow map reflect, around where the pixel lies in it.

    Dachsbacher, Stamminger, "Reflective Shadow Maps", I3D 2005. Texels nearer than the radius count; nobody asks what stands between. The
    taps are as dense as 1 / distance, and weigh as much as the distance, which is what makes the sum an integral.
    """
    samplers = {"u_shadow": SHADOW_DEPTH, "u_shadow_normal": SHADOW_NORMAL, "u_shadow_color": SHADOW_COLOR}
    uniforms: dict[str, Uniform] = {"u_taps": FloatTable.of(_circle(job.taps)), **job.uniforms}
    lit = ("u_shadow_place", "u_shadow_sides", "u_shadow_light")
    return _gather(job, Fullscreen("gather_rsm.frag", samplers, uniforms, lit=lit))


def from_screen(job: Gathering) -> Pass:
    """Gather what surfaces reflect that stand before points of the hemisphere around the pixel.

    Ritschel, Grosch, Seidel, "Approximating Dynamic Global Illumination in Image Space", I3D 2009: each of n taps stands for pi radius^2 / n of
    surface, whatever it meets.
    """
    samplers = {"u_z": DEPTH, "u_normals": NORMAL, "u_bounce": BOUNCE}
    uniforms: dict[str, Uniform] = {
        "u_taps": FloatTable.of(_hemisphere(job.taps)),
        "u_max_radius": job.most or ANY,
        **job.uniforms,
        "u_bounce_texel": ViewValue("resource_size", job.scale, inverse=True, resource=BOUNCE),
    }
    return _gather(job, Fullscreen("gather_ssdo.frag", samplers, uniforms))


def _hemisphere(count: int) -> NDArray[np.float32]:
    """Return directions (count, 4) about +z of equal solid angle, float32, each with a distance; these are even in 0..1."""
    up = (np.arange(count) + 0.5) / count
    distance = [radical_inverse(i) for i in range(count)]
    return np.column_stack([_circle(count) * np.sqrt(1 - up**2)[:, None], up, distance]).astype(np.float32)


def _circle(count: int) -> NDArray[np.float32]:
    """Return unit vectors (count, 2) in steps of the golden angle."""
    disk = Kernel(count=count).points()
    return disk / np.linalg.norm(disk, axis=1, keepdims=True)  # type: ignore[no-any-return]


def _noise(tile: int) -> NDArray[np.float32]:
    """Return a tile (tile, tile, 4) of unit vectors to reflect taps at, of places in 0..1 between two taps, in another order, and of 0."""
    turns = Rotation(tile=tile).vectors()
    order = np.rint(np.arctan2(turns[..., 1], turns[..., 0]) / np.pi * tile**2 - 0.5)
    place = (order * 7 % tile**2 + 0.5) / tile**2
    return np.concatenate([turns, np.stack([place, np.zeros_like(place)], -1)], -1).astype(np.float32)


def _gather(job: Gathering, draw: Fullscreen) -> Pass:
    """Return the pass of a draw that reads the pixel itself and writes what it gained."""
    more = extra_signals((GAINED,), None, VISIBILITY_RAW if job.packed else VISIBILITY, job.scale)
    pixel = PIXEL[job.scale > 1]
    samplers: Mapping[str, str] = {
        **draw.samplers, "u_pixel_z": pixel[PIXEL_DEPTH], "u_pixel_normal": pixel[PIXEL_NORMAL]
    }  # fmt: skip
    defines: dict[str, Define] = {**draw.defines, "TAPS": job.taps, **({"SMALL": 1} if job.scale > 1 else {})}
    turns = {"u_turns": FloatTable.of(_noise(job.tile))}
    made = Fullscreen(draw.shader, samplers, draw.uniforms, turns, defines, draw.lit)
    return Pass("gathered light", "occlusion", made, more.writes, test=job.test, clear=(0.0,) * 4)
