"""Visibility bitmasks over slices of the hemisphere, with sectors of equal cosine-weighted measure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..graph.draws import Define, ViewValue
from ..graph.names import BENT_NORMAL, DEPTH, DEPTH_LAYER_2, GAINED, PIXEL_DEPTH, PIXEL_NORMAL, VISIBILITY
from ..sampling.disk import bayer
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits
from .veil_fits import VeilFit, veil_fit

LAYER_GAP = 0.5
"""Radii between the layers: what lies nearer is mostly within a slab, and a layer spent on it is lost."""

REFINED_SLICES = 2
"""Of pixels that are drawn again at full size: no filter averages their noise away."""

FALLOFFS = ("hard", "quadratic", "obscurance", "alchemy")
"""As in :class:`ssao_gl.falloff.Falloff`; the shader knows them by number."""


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Bitmask:
    """Slices whose occluders are slabs, kept in 32 bits of equal measure.

    After Therrien, Levesque, Gilet, "Screen Space Indirect Lighting with Visibility Bitmask", 2023. There the sectors are
    equal in angle, which is not the measure of cosine-weighted occlusion; here each stands for the same share of the
    slice integral of Jimenez et al., "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016. Slices are
    averaged by their weights, so a plane is exactly open at any tilt. Taps never leave the image.
    """

    name: ClassVar[str] = "bitmask"
    shader: ClassVar[str] = "methods/bitmask.frag"
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "draft": {"scale": 4, "steps": 4},
        "low": {"scale": 2, "steps": 5},
        "medium": {},
        "high": {"steps": 8, "layers": 2, "layer_scale": 4, "refine": 0.02},
        "ultra": {"scale": 1, "slices": 1, "steps": 12, "layers": 2, "layer_scale": 2},
    }

    radius: float | None = setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)
    slices: int = setting(2, "directions through each pixel", low=1, high=16)
    steps: int = setting(9, "taps to each side of a slice", low=1, high=64)
    tile: int = setting(4, "width of the noise tile: 1, 2, 4 or 8; the filter averages it away", unit="pixels", low=1, high=8)
    thickness: float | None = setting(
        None, "of what a texel shows, behind it; none: as fitted, like the shares below", unit="radii", low=0, high=1000
    )
    bridge: float = setting(2.5, "thickness added per distance to the next tap, so that slabs leave no gaps", low=0, high=1000)
    opacity: float | None = setting(
        None, "share by which a slab hides; 1, with veils of 0, is what a depth buffer shows", low=0, high=1
    )
    near_veil: float | None = setting(
        None, "share by which all that lies behind a texel is hidden, where that is within 1.5 radii", low=0, high=1
    )
    veil: float | None = setting(None, "likewise, where it is within 3 radii", low=0, high=1)
    layers: int = setting(
        1, "2: also what lies directly behind (the renderer draws it; arrays and effects have one)", low=1, high=2
    )
    layer_scale: int = setting(
        1, "1, 2 or 4: pixels of the image along each side of a texel of what lies behind", low=1, high=4
    )
    falloff: str = setting("hard", "how an occluder counts with its distance, as in ray-traced truth", choices=FALLOFFS)
    scale: int = setting(
        2, "1, 2 or 4: pixels of the image along each side of a pixel for which occlusion is drawn", low=1, high=4
    )
    refine: float = setting(
        0.0, "pixels whose surface the smaller image knows by less than this are drawn again at full size", low=0, high=1
    )
    adaptive: bool = setting(False, "probe blocks of 16 pixels first; where they and all around see nothing no taps are spent")
    guard: float = setting(
        0.04, "of the image's height, drawn around it (by a renderer) so that taps see what lies beside", low=0, high=1
    )
    max_radius: float = setting(
        1024.0, "largest footprint; nearer surfaces get a smaller reach", unit="pixels", low=1, high=4096
    )

    def __post_init__(self) -> None:
        validate(self)
        for name, known in (("scale", (1, 2, 4)), ("layer_scale", (1, 2, 4)), ("tile", (1, 2, 4, 8))):
            if getattr(self, name) not in known:
                raise SettingsError(f"bitmask.{name}={getattr(self, name)}: must be one of {', '.join(map(str, known))}")

    @property
    def traits(self) -> Traits:
        layers, fit = {"second_layer"} if self.layers == 2 else set(), self.fitted
        return Traits(
            inputs=frozenset({"depth", "normal", *layers}),
            outputs=frozenset({VISIBILITY, BENT_NORMAL, GAINED}),
            scale=self.scale,
            noise_tile=self.tile,
            guard_band=self.guard,
            unguarded=dataclasses.replace(self, guard=0.0) if self.guard else None,
            max_reach=self.max_radius,
            occluder_reach=3.0 if fit.veil else 1.5 if fit.near_veil else 1.0,
            layer_gap=LAYER_GAP,
            layer_scale=self.layer_scale,
            exactly_open=True,  # what stands less than a sector above the tangent plane hides nothing
            taps=self.slices * self.steps,
            taps_setting="slices",
            probe_setting="adaptive",
            probe=dataclasses.replace(self, slices=4, steps=6, tile=1) if self.adaptive else None,
            single_layer=dataclasses.replace(self, layers=1) if self.layers == 2 else None,
            refine_below=self.refine,
            refined=dataclasses.replace(self, slices=max(REFINED_SLICES, self.slices)) if self.refine else None,
        )

    @property
    def fitted(self) -> VeilFit:
        """Shares and thickness: those given, and for the rest those fitted to settings like these."""
        fit = veil_fit("two layers" if self.layers == 2 else "scale 4" if self.scale == 4 else "one layer")
        given = {name: getattr(self, name) for name in ("opacity", "near_veil", "veil", "thickness")}
        return dataclasses.replace(fit, **{name: value for name, value in given.items() if value is not None})

    @property
    def samplers(self) -> Mapping[str, str]:
        return {
            "u_z": DEPTH,
            "u_pixel_z": PIXEL_DEPTH,
            "u_pixel_normal": PIXEL_NORMAL,
            **({"u_z2": DEPTH_LAYER_2} if self.layers == 2 else {}),
        }

    def defines(self) -> Mapping[str, Define]:
        every: dict[str, Define] = {"SLICES": self.slices, "STEPS": self.steps}
        every |= {"SECOND_LAYER": 1} if self.layers == 2 else {}
        fit = self.fitted
        every |= {"VEIL": 1} if (fit.opacity, fit.near_veil, fit.veil) != (1.0, 0.0, 0.0) else {}
        return every | ({"FALLOFF": FALLOFFS.index(self.falloff)} if self.falloff != "hard" else {})

    def constants(self) -> Mapping[str, Any]:
        if self.radius is None:
            raise SettingsError("the radius must be settled before the draw")
        angle, fit = math.pi / self.slices, self.fitted
        shares = {"u_shares": (fit.opacity, fit.near_veil, fit.veil)} if "VEIL" in self.defines() else {}
        behind = ViewValue("resource_size", self.layer_scale, inverse=True, resource=DEPTH_LAYER_2)
        return (
            shares
            | ({"u_behind_texel": behind, "u_behind_scale": float(self.layer_scale)} if self.layers == 2 else {})
            | {
                "u_per_radius": 1 / self.radius,
                "u_thickness": (fit.thickness, self.bridge),
                "u_max_radius": self.max_radius,
                "u_noise_width": float(self.tile),
                "u_next_slice": (math.cos(angle), math.sin(angle)),
            }
        )

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        """Directions and step offsets, both stratified over the tile and in an order that sets neighbours apart.

        For bent normals also the mean directions of the eighths of a slice.
        """
        count = self.tile**2
        order = bayer(self.tile).reshape(self.tile, self.tile)
        angle = (order + 0.5) / count * math.pi / self.slices
        offset = (order * 7 % count + 0.5) / count
        noise = np.stack([np.cos(angle), np.sin(angle), offset, np.zeros_like(offset)], -1).astype(np.float32)
        return {"u_noise": noise, **({"u_directions": octant_directions()} if BENT_NORMAL in outputs else {})}


def octant_directions(width: int = 128, steps: int = 4096) -> NDArray[np.float32]:
    """Mean directions of the eighths of a slice's measure (4, width, 4), two in a texel: along the slice, and to the viewer.

    Column i is for a normal in the slice at the angle gamma from the viewer, with sines evenly from -1 to 1; the measure of an
    angle t from the viewer is ``cos(t - gamma) |sin t|`` (see ``shaders/lib/slice.glsl``).
    """
    gamma = np.arcsin(np.linspace(-1, 1, width))[:, None]
    t = gamma + np.pi * ((np.arange(steps) + 0.5) / steps - 0.5)
    measure = np.cos(t - gamma) * np.abs(np.sin(t))
    share = (np.cumsum(measure, 1) - measure / 2) / measure.sum(1, keepdims=True)
    part = np.minimum((8 * share).astype(int), 7)
    sums = [
        [np.bincount(p, m * f(a), 8) / np.bincount(p, m, 8) for p, m, a in zip(part, measure, t, strict=True)]
        for f in (np.sin, np.cos)
    ]
    return np.stack(sums, -1).reshape(width, 4, 4).transpose(1, 0, 2).astype(np.float32)
