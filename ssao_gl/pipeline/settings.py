"""Everything that decides a picture but the scene, the camera and the size."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from ..errors import SettingsError, near_miss, one_line
from ..glsl.preprocess import Define
from ..graph.names import PIXEL_DEPTH
from ..methods.base import Method
from ..methods.bitmask import Bitmask
from ..methods.registry import method
from ..passes.denoise import Filter, Joint, filter_named
from ..settings import as_table, setting, validate
from .colors import NAMED, SOLID, check_color, linear_rgb, rgba
from .light import Light

GUARD_STEP = 16

CALM = "#9aa5b1"
"""Behind a scene without a background: white and black parts, and those of the default grey, all stand out from it."""

CULLING_RULES: Mapping[str, str] = {
    "background": "pixels that show nothing are not shaded",
    "open": "blocks of pixels above whose tangent planes nothing stands within the radius are 1 without a tap",
    "adaptive": "blocks whose probe sees nothing get no taps, for methods that are set to be adaptive",
}
"""What is left out where a scene does not need it, by the name that keeps it in."""

PRECISIONS: Mapping[str, Mapping[str, Define]] = {"high": {}, "mobile": {"MOBILE": 1}}
"""What shaders are told of the precision; see ``lib/precision.glsl``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shading:
    """How the picture is lit: an ambient part that occlusion dims, and a light over the viewer's shoulder."""

    ambient: float = setting(0.75, "share of the light that is ambient; for apply: strength of the occlusion", low=0, high=1)
    background: str | None = setting(
        None,
        "sRGB behind the scene in the image: #rrggbb, #rrggbbaa, white, black, transparent; auto: the scene's own, else a grey blue",
    )
    halo: float = setting(0.0, "strength of the halo around what is in front of something else", low=0, high=1)
    halo_color: str = setting("black", "sRGB of the halo: #rrggbb, white, black")
    halo_width: float = setting(0.02, "of the halo", unit="share of the image's height", above=0, high=1)

    tint: str = setting("black", "sRGB of the ambient light that is left where all is hidden: #rrggbb, white, black")
    power: float = setting(1.0, "contrast of the occlusion in the image: visibility to this power", above=0, high=16)

    def __post_init__(self) -> None:
        validate(self)
        check_color("shading.tint", self.tint, SOLID)
        if self.background is not None:
            check_color("shading.background", self.background, NAMED)
        check_color("shading.halo_color", self.halo_color, SOLID)

    @property
    def background_rgba(self) -> tuple[float, float, float, float]:
        """Return sRGB and alpha in 0..1; a calm grey blue where nothing was chosen."""
        return rgba(self.background or CALM)

    @property
    def halo_rgba(self) -> tuple[float, float, float, float]:
        """Return sRGB and alpha in 0..1."""
        return rgba(self.halo_color)

    @property
    def tint_linear(self) -> tuple[float, float, float]:
        """Return linear light in 0..1."""
        return linear_rgb(self.tint)

    @property
    def toned(self) -> bool:
        """Whether tint or power change the image."""
        return self.power != 1 or any(self.tint_linear)

    def before(self, own: Sequence[float] | None) -> Shading:
        """Return this shading with its background settled: the chosen one, a scene's ``own`` (sRGB and alpha in 0..1), or the calm one."""
        if self.background is not None:
            return self
        text = CALM if own is None else "#" + "".join(f"{round(255 * value):02x}" for value in own)
        return dataclasses.replace(self, background=text)


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Everything that decides a picture but the scene, the camera and the size."""

    method: Method = field(default_factory=Bitmask)
    blur: Filter | None = field(default_factory=Joint)
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
    rays: float = setting(
        0.0,
        "rays a pixel that correct what the screen cannot know, any share; 0: none; they need a scene and the extra truth",
        low=0,
        high=4096,
    )
    light: Light | None = None
    """Lamps, shadows and light from all around; None: an ambient part and a light over the viewer's shoulder, by ``shading``."""
    supersample: int = setting(
        1, "samples a pixel along each side, for smooth edges; occlusion is drawn for fewer where its method can", low=1, high=3
    )
    exclude: tuple[str, ...] = ()
    """Names of things or materials (``*`` stands for any letters) that receive no occlusion; with ``:casts``: that cast none."""
    keep: tuple[str, ...] = ()
    """Rules of leaving out that are switched off, of :data:`CULLING_RULES`."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "method", as_method(self.method))
        object.__setattr__(self, "blur", as_filter(self.blur))
        if not isinstance(self.shading, Shading):
            raise SettingsError(f"shading={self.shading!r}: must be a Shading, like Shading(ambient=0.75)")
        if not isinstance(self.light, Light | None):
            raise SettingsError(
                f"light={one_line(repr(self.light), 60)}: must be a Light, like Light(azimuth=-40, elevation=50)"
            )
        validate(self)
        names: Any = self.exclude
        if isinstance(names, str) or not all(isinstance(name, str) and name for name in names):
            raise SettingsError(f"exclude={names!r}: must be names, like ('glass', 'lamp*:casts')")
        object.__setattr__(self, "exclude", tuple(names))
        for rule in self.keep:
            if rule not in CULLING_RULES:
                raise SettingsError(
                    f"keep='{rule}': there is no such rule; there are {', '.join(CULLING_RULES)}.{near_miss(rule, CULLING_RULES)}"
                )

    def with_radius(self, radius: float) -> Settings:
        """Return these settings with an automatic radius settled to ``radius`` scene units."""
        if self.method.radius is not None:
            return self
        return dataclasses.replace(self, method=dataclasses.replace(self.method, radius=radius))  # type: ignore[type-var]

    def settled(self, radius: float, background: Sequence[float] | None) -> Settings:
        """Return these settings with what is automatic as a view has it: ``radius`` in scene units, a scene's own ``background``."""
        return dataclasses.replace(self.with_radius(radius), shading=self.shading.before(background))

    def table(self) -> dict[str, Any]:
        """All settings as plain values, by group: for JSON and for the text chunks of pictures."""
        return {
            "method": self.method.name,
            self.method.name: as_table(self.method),
            "blur": self.blur.name if self.blur else "none",
            **({f"blur_{self.blur.name}": as_table(self.blur)} if self.blur else {}),
            "shading": as_table(self.shading),
            "normals": self.normals,
            "precision": self.precision,
            **({"rays": self.rays} if self.rays else {}),
            **({"light": as_table(self.light)} if self.light else {}),
            **({"supersample": self.supersample} if self.supersample > 1 else {}),
            **({"exclude": list(self.exclude)} if self.exclude else {}),
            **({"keep": list(self.keep)} if self.keep else {}),
        }


def as_method(value: Method | str | None) -> Method:
    """Return a method from its name, or itself; None is the default. Raises SettingsError."""
    if value is None:
        return Bitmask()
    made = method(value) if isinstance(value, str) else value
    return cast(Method, _record("method", made, "Bitmask(radius=0.3)"))


def as_filter(value: Filter | str | None) -> Filter | None:
    """Return a filter from its name, or itself; None is none. Raises SettingsError."""
    if value is None:
        return None
    made = filter_named(value) if isinstance(value, str) else value
    return made if made is None else cast(Filter, _record("blur", made, "Joint(radius=2)"))


def _record(name: str, value: Any, like: str) -> Any:
    """Raise SettingsError for what is no record of settings, or only its class."""
    if isinstance(value, type):
        raise SettingsError(f"{name}={value.__name__}: is a class; make one of it: {value.__name__}()")
    if not (dataclasses.is_dataclass(value) and hasattr(value, "traits")):
        raise SettingsError(f"{name}={one_line(repr(value), 60)}: must be a name in quotes, or settings like {like}")
    return value


def drawn_scale(settings: Settings) -> int:
    """Return how many pixels of the frame along each side one stands for that occlusion is drawn for.

    1 under filters that work at full size alone. A method that can be drawn at a smaller size takes no more than one of the samples of
    a pixel: edges are the G-buffer's, and occlusion finds them as it is brought to its size.
    """
    if settings.blur is not None and not settings.blur.traits.scales:
        return 1
    scale = settings.method.traits.scale
    shrinks = PIXEL_DEPTH in settings.method.samplers.values()
    return max(scale, settings.supersample) if shrinks else scale


def drawn_filter(settings: Settings) -> Filter | None:
    """Return the filter that is drawn: one whose width follows the noise has nothing to do where there is none."""
    idle = settings.blur is not None and settings.blur.radius is None and not settings.method.traits.noise_tile
    return None if idle else settings.blur


def guard_band(method: Method, height: int) -> int:
    """Return the pixels that are drawn around an image of that height on each side, so that taps see what lies beside.

    A multiple of ``GUARD_STEP``, so that noise and smaller images keep their places.
    """
    return math.ceil(method.traits.guard_band * height / GUARD_STEP) * GUARD_STEP
