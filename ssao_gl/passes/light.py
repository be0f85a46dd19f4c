"""Light: a shadow map, and the image under lamps and light from all around."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Define, DrawScene, Fullscreen, Uniform
from ..graph.names import (
    BENT_NORMAL,
    BOUNCE,
    COLOR,
    DEPTH,
    GAINED,
    IMAGE,
    MATERIAL,
    NORMAL,
    SHADING_NORMAL,
    SHADOW_COLOR,
    SHADOW_DEPTH,
    SHADOW_MASK,
    SHADOW_NORMAL,
    VISIBILITY,
)  # fmt: skip
from .gbuffer import SHADERS

GATHERED = ("ssdo", "rsm")
"""Light of one bounce that passes beside occlusion gather."""
INDIRECT = ("none", "tint", "bitmask", *GATHERED)
"""Where light comes from that has bounced: nowhere, the surface's own colour, what hides a pixel, what lies around it."""
MOST_LAMPS = 8
"""Lamps of a scene that light a picture."""
SHADOW_EYE = "key light"
"""Whose eye the shadow map is drawn from."""
NOTHING = 1e30
"""Depth in a shadow map where nothing casts."""

SKY_VALUES = ("u_sky", "u_sky_from_view")
LAMP_VALUES = ("u_lamp_place", "u_lamp_color", "u_lamp_axis")
SHADOW_VALUES = ("u_shadow_place", "u_shadow_sides", "u_shadow_texel")


@dataclass(frozen=True, slots=True)
class Sources:
    """What falls on surfaces. lamps: how many there is room for. shadows: the first one's are looked up. sky: the environment
    depends on the direction."""

    lamps: int
    shadows: bool
    sky: bool

    @property
    def samplers(self) -> dict[str, str]:
        """Sampler uniform -> resource."""
        lamps = {"u_z": DEPTH} if self.lamps else {}
        return lamps | ({"u_geometric": NORMAL, "u_shadow": SHADOW_DEPTH} if self.shadows else {})

    @property
    def lit(self) -> tuple[str, ...]:
        """Uniforms whose values every frame brings."""
        lamps, shadows = LAMP_VALUES if self.lamps else (), SHADOW_VALUES if self.shadows else ()
        return *(SKY_VALUES if self.sky else ("u_sky_even",)), *lamps, *shadows

    @property
    def defines(self) -> dict[str, Define]:
        """What the shader must do, and no more."""
        return {"LAMPS": self.lamps, **({"SHADOWS": 1} if self.shadows else {}), **({"SKY": 1} if self.sky else {})}


def shadow_map(side: int, *, reflective: bool = False) -> Pass:
    """Draw the distance along the key light of what it meets first, ``side`` x ``side`` texels. Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978.

    reflective: with its normals and base colours, so that it can be gathered from; see :func:`ssao_gl.passes.gather.from_shadow_map`.
    """
    clears: dict[str, tuple[float, ...]] = {SHADOW_DEPTH: (NOTHING,) * 4}
    targets = {SHADOW_DEPTH: Texture("r32f", side=side)}
    if reflective:
        clears |= dict.fromkeys((SHADOW_NORMAL, SHADOW_COLOR), (0.0,) * 4)
        targets |= {SHADOW_NORMAL: Texture("rg16f", side=side), SHADOW_COLOR: Texture("rgba8", side=side)}
    draw = DrawScene(SHADERS, clears, view=SHADOW_EYE)
    return Pass("shadow map", "shadow", draw, targets, depth=SHADOW_MASK)


def reflected_light(sources: Sources, scale: int, hidden_sky: float) -> Pass:
    """Draw what pixels reflect of lamps and of an open environment, everywhere in the frame: taps look at all of it.

    scale: pixels of the image along each side of a texel, as occlusion has them. hidden_sky: 1 where what reflects the environment sees as little of it as what gathers
    that, 0 where it sees all.
    """
    samplers = {**sources.samplers, "u_color": COLOR, "u_normal": SHADING_NORMAL}
    values: dict[str, Uniform] = {"u_hidden_sky": hidden_sky}
    draw = Fullscreen("bounce.frag", samplers, values, defines=sources.defines, lit=sources.lit)
    return Pass("reflected light", "prepare", draw, {BOUNCE: Texture("rgba16f", 1 / scale)})


def light_image(
    sources: Sources,
    background: Sequence[float],
    *,
    bent: bool,
    specular: float,
    indirect: str,
    hidden_sky: float,
    tone: str,
    test: DepthTest | None = None,
    result: str = IMAGE,
) -> Pass:
    """Draw ``result``: linear light of lamps and environment on base colour, as sRGB; ``background`` (sRGB, alpha) where ``test`` finds nothing.

    bent: the environment is looked up in the bent normal's direction. specular: strength of what shines, 0 for none. indirect: see :data:`INDIRECT`. hidden_sky: see
    :func:`reflected_light`.
    """
    bounced = indirect == "bitmask" or indirect in GATHERED
    samplers = {**sources.samplers, "u_color": COLOR, "u_visibility": VISIBILITY, "u_normal": SHADING_NORMAL}
    samplers |= {"u_z": DEPTH} if specular else {}
    samplers |= {"u_gained": GAINED} if bounced else {}
    samplers |= {"u_bent": BENT_NORMAL} if bent else {}
    samplers |= {"u_material": MATERIAL} if specular else {}
    defines = sources.defines | {
        **({"BENT_SKY": 1} if bent else {}),
        **({"SPECULAR": 1} if specular else {}),
        **({"BOUNCED": 2 if indirect in GATHERED else 1} if bounced else {}),
        **({"TINT": 1} if indirect == "tint" else {}),
        **({"TONE": 1} if tone != "none" else {}),
    }
    uniforms: dict[str, Uniform] = {"u_specular": specular} if specular else {}
    uniforms |= {"u_hidden_sky": hidden_sky} if indirect == "bitmask" else {}
    draw = Fullscreen("light.frag", samplers, uniforms, defines=defines, lit=sources.lit)
    return Pass("light", "composite", draw, {result: Texture("rgba8")}, test=test, clear=tuple(background))
