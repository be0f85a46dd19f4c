"""From settings to a frame graph: which passes there are, and the plans that the renderer and the effect run."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .camera import Camera, Part
from .errors import SettingsError, near_miss
from .graph import Pass, Plan, Test, compile
from .methods import Method, method
from .methods.bitmask import Bitmask
from .passes import screen, skip, small
from .passes.bent import BENT
from .passes.blur import Blur, Joint
from .settings import setting, validate
from .sources import Define
from .view import Size

AOVS = ("image", "visibility", "depth", "normal", "bent", "color")
"""What a picture can hold: shaded image, visibility, linear depth, view-space normals, mean open directions, base colour."""

GUARD_STEP = 16

RULES: Mapping[str, str] = {
    "background": "pixels that show nothing are not shaded",
    "open": "blocks of pixels above whose tangent planes nothing stands within the radius are 1 without a tap",
    "adaptive": "blocks whose probe sees nothing get no taps, for methods that are set to be adaptive",
}
"""What is left out where a scene does not need it, by the name that keeps it in."""

RESOURCES: Mapping[str, str] = {
    "image": "image",
    "visibility": "visibility",
    "depth": "z",
    "normal": "shading_normal",
    "bent": BENT,
    "color": "color",
}
"""AOV -> resource of the graph."""

PRECISIONS: Mapping[str, Mapping[str, Define]] = {"high": {}, "mobile": {"MOBILE": 1}}
"""What shaders are told of the precision; see ``lib/precision.glsl``."""

WINDOW_DEPTH, EYE_DEPTH = "window", "eye"


@dataclass(frozen=True, slots=True, kw_only=True)
class Shading:
    """How the picture is lit: an ambient part that occlusion dims, and a light over the viewer's shoulder."""

    ambient: float = setting(0.75, "share of the light that is ambient; for apply: strength of the occlusion", low=0, high=1)
    background: str = setting("#ffffff", "sRGB colour behind the scene, #rrggbb")

    def __post_init__(self) -> None:
        validate(self)
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", self.background):
            raise SettingsError(f"shading.background='{self.background}': must look like #rrggbb")

    @property
    def background_rgb(self) -> tuple[float, float, float]:
        r, g, b = (int(self.background[i : i + 2], 16) / 255 for i in (1, 3, 5))
        return r, g, b


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Everything that decides a picture but the scene, the camera and the size."""

    method: Method = field(default_factory=Bitmask)
    blur: Blur | None = field(default_factory=Joint)
    shading: Shading = field(default_factory=Shading)
    normals: str = setting(
        "geometric",
        "what occlusion goes by: the triangles' own normals, as rays do, or the mesh's smooth ones",
        choices=("geometric", "shading"),
    )
    precision: str = setting(
        "high",
        "mobile: weights and colours as half floats, where the driver has them; never what is a length",
        choices=tuple(PRECISIONS),
    )
    keep: tuple[str, ...] = ()
    """Rules of leaving out that are switched off, of :data:`RULES`."""

    def __post_init__(self) -> None:
        validate(self)
        for rule in self.keep:
            if rule not in RULES:
                raise SettingsError(
                    f"keep='{rule}': there is no such rule; there are {', '.join(RULES)}.{near_miss(rule, RULES)}"
                )

    def with_radius(self, radius: float) -> Settings:
        """These settings with an automatic radius settled to ``radius`` scene units."""
        if self.method.radius is not None:
            return self
        return dataclasses.replace(self, method=dataclasses.replace(self.method, radius=radius))  # type: ignore[type-var]

    def table(self) -> dict[str, Any]:
        """All settings as plain values, by group: for JSON and for the text chunks of pictures."""
        from .settings import as_table

        return {
            "method": self.method.name,
            self.method.name: as_table(self.method),
            "blur": self.blur.name if self.blur else "none",
            **({f"blur_{self.blur.name}": as_table(self.blur)} if self.blur else {}),
            "shading": as_table(self.shading),
            "normals": self.normals,
            "precision": self.precision,
            **({"keep": list(self.keep)} if self.keep else {}),
        }


def as_method(value: Method | str | None) -> Method:
    """A method from its name, or itself; None is the default."""
    if value is None:
        return Bitmask()
    return method(value) if isinstance(value, str) else value


def small_scale(settings: Settings) -> int:
    """How many pixels of the image along each side one stands for that occlusion is drawn for.

    1 for methods that cannot be drawn smaller, and under filters that work at full size alone.
    """
    scale: int = getattr(settings.method, "scale", 1)
    return scale if settings.blur is None or isinstance(settings.blur, Joint) else 1


def guard(settings: Settings, camera: Camera, size: Size) -> int:
    """Pixels that a renderer draws around the image on each side, so that taps see what lies beside.

    A multiple of ``GUARD_STEP``, so that noise and smaller images keep their places.
    """
    height = camera.lens.whole[1] if isinstance(camera.lens, Part) else size[1]
    return math.ceil(getattr(settings.method, "guard", 0.0) * height / GUARD_STEP) * GUARD_STEP


@dataclass(frozen=True, slots=True)
class Leaving:
    """How a plan finds what need not be shaded.

    background: it is left out. cover: the depth test at full size that does so, None without. blocks: passes that find open
    blocks; none when nobody looks for them, for the reason ``why``.
    """

    background: bool
    cover: Test | None
    blocks: tuple[Pass, ...]
    why: str


def leaving(
    settings: Settings, cover: Test | None, size: Size, triangles: int | None, *, flat_normals: bool, bent: bool = False
) -> Leaving:
    """What is left out. ``triangles`` of a scene that surrounds the camera; ``flat_normals``: normals are those that depth shows;
    ``bent``: bent normals are drawn too."""
    method, keep = settings.method, settings.keep
    background = "background" not in keep
    cover = cover if background else None
    if bent and settings.blur is None and small_scale(settings) == 1:
        return Leaving(background, cover, (), "bent normals without a filter are drawn everywhere")
    if getattr(method, "adaptive", False) and "adaptive" not in keep:
        return Leaving(background, cover, (screen.probe(method, skip.PROBE, skip.BLOCK), skip.probed_blocks()), "")
    taps = getattr(method, "slices", 1) * getattr(method, "steps", 0) / small_scale(settings) ** 2
    why = ""
    if not getattr(method, "open_is_exact", False):
        why = f"{method.name} may darken what nothing stands above"
    elif "open" in keep:
        why = "switched off"
    elif not flat_normals:
        why = "normals are not those of the surface that depth shows"
    elif taps < skip.STEPS:
        why = f"{taps:g} taps a pixel and side cost less than looking for blocks to leave out"
    elif triangles is None:
        why = "the scene does not surround the camera (or is not known): most of what is open is background"
    elif triangles * skip.TRIANGLE > size[0] * size[1]:
        why = f"with {triangles:,} triangles in {size[0]}x{size[1]} pixels few blocks are flat"
    return Leaving(background, cover, () if why else (skip.bounds(), skip.open_blocks(method.radius, method.max_radius)), why)  # type: ignore[attr-defined]


def _after_gbuffer(settings: Settings, left: Leaving, *, bent: bool) -> list[Pass]:
    """All passes to ``visibility``, and to bent normals."""
    if bent:
        _check_bent(settings)
    method, blur, scale, cover = settings.method, settings.blur, small_scale(settings), left.cover
    tile = getattr(method, "tile", 4)
    over = skip.UNTOUCHED if left.blocks else None
    if scale == 1:
        packed = blur is not None
        return [
            screen.over_far(),
            *left.blocks,
            *([skip.todo(packed=packed)] if over else []),
            screen.occlusion(method, packed=packed, test=Test(skip.TODO) if over else cover, over=over, bent=bent),
            *_filters(blur, tile, cover, bent),
        ]
    least = getattr(method, "refine", 0.0)
    tolerance = blur.tolerance if isinstance(blur, Joint) else Joint().tolerance
    todo, seen = (Test(skip.TODO, equal=equal) if left.background or over else None for equal in (False, over is not None))
    return [
        *left.blocks,
        small.shrink(scale, open_blocks=over is not None),
        screen.occlusion(method, packed=True, scale=scale, test=todo, over=over, bent=bent),
        *(blur.small_passes(tile, scale, seen if left.background else None, bent=bent) if isinstance(blur, Joint) else []),
        small.upsample("small visibility" if blur else "raw", scale, tolerance, cover, least, bent=bent),
        *([screen.refine(method, small.MISSED)] if least else []),
    ]


def _filters(blur: Blur | None, tile: int, cover: Test | None, bent: bool) -> list[Pass]:
    """The filter's passes at full size."""
    if isinstance(blur, Joint):
        return blur.passes(tile, cover, bent=bent)
    return blur.passes(tile, cover) if blur else []


def _check_bent(settings: Settings) -> None:
    """Raises SettingsError where bent normals cannot be had."""
    if not hasattr(settings.method, "bent"):
        raise SettingsError(f"bent: {settings.method.name} does not know which directions are open; use the method bitmask")
    if settings.blur is not None and not isinstance(settings.blur, Joint):
        raise SettingsError(f"bent: the filter {settings.blur.name} is for visibility alone; use joint, or none")


def _at(precision: str, passes: Sequence[Pass]) -> list[Pass]:
    """The passes, with shaders of that precision."""
    defines = PRECISIONS[precision]

    def precise(task: Pass) -> Pass:
        return dataclasses.replace(task, draw=lambda stage: task.draw(dataclasses.replace(stage, defines=defines)))

    return [precise(task) for task in passes] if defines else list(passes)


def _notes(settings: Settings, left: Leaving) -> dict[str, str]:
    return ({} if settings.blur else {"blur": "switched off"}) | ({"open blocks": left.why} if left.why else {})


def resources(aovs: Sequence[str]) -> list[str]:
    """Resource names of some AOVs. Raises SettingsError for an unknown one."""
    for name in aovs:
        if name not in AOVS:
            raise SettingsError(f"unknown AOV '{name}'; there are {', '.join(AOVS)}.{near_miss(name, AOVS)}")
    wanted = [RESOURCES[name] for name in aovs]
    # Directions are zero on background, which depth tells. Bent normals are drawn beside visibility.
    more = [*(["z"] if {"normal", "bent"} & set(aovs) else []), *(["visibility"] if "bent" in aovs else [])]
    return list(dict.fromkeys([*wanted, *more]))


def plan_render(settings: Settings, size: Size, aovs: Sequence[str] = ("image",), *, triangles: int | None = None) -> Plan:
    """The plan that draws a scene. ``triangles``: how many it has, if it surrounds the camera; None if not."""
    from .passes.gbuffer import gbuffer, layer_behind

    flat = settings.normals == "geometric"
    left = leaving(settings, Test(screen.COVER, far=True), size, triangles, flat_normals=flat, bent="bent" in aovs)
    passes = [
        gbuffer(settings.shading.background_rgb, geometric=settings.normals == "geometric"),
        layer_behind(),
        *_after_gbuffer(settings, left, bent="bent" in aovs),
        screen.composite(settings.shading.ambient, settings.shading.background_rgb, direct=True),
    ]
    return compile(_at(settings.precision, passes), size, resources(aovs), notes=_notes(settings, left))


def plan_filter(blur: Blur, size: Size) -> Plan:
    """The plan that filters a visibility from elsewhere, the input ``given``, by the depth and normals of a scene."""
    from .passes.gbuffer import gbuffer

    return compile(
        [gbuffer(Shading().background_rgb, geometric=True), screen.pack(), *blur.passes()], size, ["visibility"], ["given"]
    )


def plan_apply(
    settings: Settings,
    size: Size,
    *,
    depth: str = WINDOW_DEPTH,
    normals: bool = False,
    outputs: Sequence[str] = ("visibility",),
) -> Plan:
    """The plan over a caller's depth (and normals, and colour)."""
    if "z2" in settings.method.samplers.values():
        raise SettingsError(f"{settings.method.name}: two layers need a scene to draw; a depth buffer has one")
    if depth not in (WINDOW_DEPTH, EYE_DEPTH):
        raise SettingsError(f"depth kind '{depth}'; must be 'eye' (distance along the view axis) or 'window' (0 to 1)")
    # A depth buffer of the image costs more memory than its one use costs time where occlusion is drawn at a smaller size.
    cover = Test(screen.COVER) if small_scale(settings) == 1 else None
    left = leaving(settings, cover, size, None, flat_normals=not normals, bent=BENT in outputs)
    notes = _notes(settings, left) | ({} if normals else {"encode normals": "no normals were given: rebuilt from depth"})
    passes = [
        screen.linearize(window=depth == WINDOW_DEPTH, cover=left.cover is not None),
        screen.encode_normals() if normals else screen.normals_from_depth(),
        *_after_gbuffer(settings, left, bent=BENT in outputs),
        screen.composite(settings.shading.ambient, (0.0, 0.0, 0.0), direct=False),
    ]
    inputs = ["depth", *(["normal_xyz"] if normals else []), *(["color"] if "image" in outputs else [])]
    return compile(_at(settings.precision, passes), size, list(outputs), inputs, notes)
