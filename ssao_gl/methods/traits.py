"""What the pipeline may ask of a method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from ..graph.names import BENT_NORMAL, GAINED, VISIBILITY

if TYPE_CHECKING:
    from .base import Method

INPUTS = ("depth", "normal", "depth_table", "second_layer", "history", "scene", "prepared", "baked")
"""What a method may need. depth, normal: of what is seen. depth_table: sums of inverse depth. second_layer: depth of what lies behind it. history: what the last
frame left. scene: the things in it themselves. prepared: data made once from the scene. baked: visibility that its meshes keep. The last five come from a renderer that
has the scene; arrays and effects have none."""

OUTPUTS = (VISIBILITY, BENT_NORMAL, GAINED)
"""What a method may draw."""

CAMERAS = {
    "perspective": "is defined for perspective cameras only; use another method",
    "far plane": "needs a far plane, since its depth is z / far; give zfar, or use another method",
}
"""What a method may need of a camera -> what is said of one without."""

NEEDS_SCENE = frozenset({"second_layer", "history", "scene", "prepared", "baked"})


@dataclass(frozen=True, slots=True)
class ElementTraits:
    """How a method adds up what each element of the scene hides.

    elements: "triangles", or "spheres": the scene's own, and those that stand for patches of its triangles. exact_sums: in 32-bit
    floats. max_fill: fragments beyond which it refuses. constants: uniforms of the element's shader, as of :meth:`.Method.constants`.
    both_sides: of triangles, also behind them. patch: the width of patches, in radii.
    """

    elements: Literal["triangles", "spheres"]
    exact_sums: bool
    max_fill: float
    constants: Mapping[str, Any]
    both_sides: bool = True
    patch: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Traits:
    """What the pipeline may ask of a method with its settings. The defaults suit a plain method of full size."""

    inputs: frozenset[str] = frozenset({"depth", "normal"})
    """Of :data:`INPUTS`."""
    outputs: frozenset[str] = frozenset({VISIBILITY})
    """Of :data:`OUTPUTS`."""
    cameras: frozenset[str] = frozenset()
    """What it needs of a camera, of :data:`CAMERAS`; it refuses others."""
    scale: int = 1
    """Pixels of the image along each side of a pixel for which occlusion is drawn."""
    noise_tile: int = 4
    """Period of its noise, in pixels of the size at which it is drawn. What a filter averages away; 0: there is none."""
    guard_band: float = 0.0
    """What is drawn around the image so that taps see what lies beside, as a share of its height."""
    unguarded: Method | None = None
    """The method without a guard band; None: it has none."""
    radius_unit: Literal["scene units", "pixels", "share of the image"] = "scene units"
    max_reach: float | None = None
    """Largest distance of a tap, pixels; None: only the radius bounds it."""
    exactly_open: bool = False
    """Whether visibility is 1 to the last bit where nothing stands above the tangent plane within the radius."""
    occluder_reach: float = 1.0
    """Within how many radii what stands above the tangent plane may darken a pixel, for the rule of open blocks."""
    layer_gap: float = 0.0
    """Radii between the first and the second layer, at least."""
    single_layer: Method | None = None
    """The method for those who have one layer; None: it looks at no more."""
    layer_scale: int = 1
    """Pixels of the image along each side of a texel of the second layer."""
    taps: int = 0
    """Taps to a side of all slices of a drawn pixel, for the rule of open blocks; 0: not known."""
    taps_setting: str | None = None
    """The setting that is the number of taps, or of what stands for it."""
    probe_setting: str | None = None
    """The setting that asks for ``probe``; None: the method has none."""
    probe: Method | None = None
    """The method for one pixel of each block, by more slices instead of a filter; None: it does not probe."""
    refine_below: float = 0.0
    """Weight of the smaller image's texels below which a pixel is drawn again, by ``refined``."""
    refined: Method | None = None
    elements: ElementTraits | None = None
    """How what it reads of the scene's elements is added up; None: it reads nothing of them."""
    affordable: Method | None = None
    """The method with fewer taps, where its own make it exhaustive: for tests by the thousand."""

    @property
    def needs_scene(self) -> bool:
        """Whether a depth buffer alone is not enough."""
        return bool(self.inputs & NEEDS_SCENE)

    @property
    def draws_arrays(self) -> bool:
        """Whether it, or the method of one layer in its place, draws depth buffers that come without a scene."""
        return not self.needs_scene or self.single_layer is not None

    @property
    def any_scene(self) -> bool:
        """Whether it draws every scene, and not those alone that keep something for it."""
        return "baked" not in self.inputs
