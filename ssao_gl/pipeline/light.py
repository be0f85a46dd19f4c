"""The light of a picture: a key light with shadows, the lamps of the scene, and light from all around."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..graph.draws import FloatTable
from ..passes.light import GATHERED, INDIRECT, MOST_LAMPS, SHADOW_EYE
from ..scene import harmonics
from ..scene.camera import Camera
from ..scene.lamps import Lamp, LitView
from ..scene.model import Scene
from ..scene.projection import Size, ViewConstants
from ..scene.shadow_view import shadow_camera
from ..settings import setting, validate
from .colors import SOLID, check_color, linear_rgb

ENVIRONMENTS: Mapping[str, harmonics.Coefficients] = {
    "none": harmonics.constant((0.0, 0.0, 0.0)),
    "white": harmonics.constant((1.0, 1.0, 1.0)),
    "sky": harmonics.gradient((0.56, 0.58, 0.62), (0.36, 0.34, 0.32)),
}
"""Light from all around by name: its coefficients."""

TONES = ("none", "neutral")


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """How a scene is lit, in linear light: ``albedo (visibility E(bent normal) + sum of lamps) + what shines``.

    Angles tell where the key light stands: azimuth to the right of the viewer, 0 is behind the back; elevation above the horizon.
    """

    azimuth: float = setting(
        -40.0, "of the key light, to the right of where one looks from", unit="degrees", low=-360, high=360
    )
    elevation: float = setting(50.0, "of the key light above the horizon", unit="degrees", low=-90, high=90)
    follows: str = setting(
        "camera",
        "what the azimuth is counted from: the viewer's back, or the scene's own +z (which fixes the sun)",
        choices=("camera", "scene"),
    )
    intensity: float = setting(0.55, "of the key light on a surface that faces it; 0: there is none", low=0, high=1e6)
    color: str = setting("#fff6e8", "sRGB of the key light: #rrggbb")
    lamps: str = setting("key", "key: the key light; scene: the lights that the scene came with", choices=("key", "scene"))
    shadows: bool = setting(False, "whether the first directional light casts shadows")
    shadow_side: int = setting(1024, "texels along each side of the shadow map", low=64, high=8192)
    environment: str = setting("sky", "light from all around", choices=(*ENVIRONMENTS, "given"))
    coefficients: tuple[float, ...] = ()
    """The 27 numbers of a ``given`` environment; see :mod:`ssao_gl.scene.harmonics`."""
    strength: float = setting(1.0, "of the environment", low=0, high=1e6)
    specular: float = setting(1.0, "of what shines; 0: everything is matt", low=0, high=1)
    indirect: str = setting(
        "none",
        "light that bounced once: none; tint, as if all around had its own colour; bitmask, what the taps reflect that hide; ssdo, what points around meet; rsm, what the shadow map shows",
        choices=INDIRECT,
    )
    gather_taps: int = setting(32, "for ssdo and rsm: taps a pixel; the filter averages those of a noise tile", low=1, high=256)
    hidden_sky: float = setting(
        1.0,
        "for bitmask and ssdo: what reflects the environment sees as little of it as what gathers that; 0: all of it",
        low=0,
        high=1,
    )
    tone: str = setting("none", "curve from linear light to the picture; none cuts off at white", choices=TONES)

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", tuple(map(float, self.coefficients)))
        validate(self)
        sky = np.asarray(self.coefficients)
        if self.environment == "given" and (sky.shape != (27,) or not np.isfinite(sky).all()):
            raise SettingsError("light.coefficients: a given environment has 27 finite numbers, nine times (r, g, b)")
        check_color("light.color", self.color, SOLID)

    @property
    def sky(self) -> NDArray[np.float64]:
        """Coefficients (9, 3) of the light from all around."""
        given = self.coefficients if self.environment == "given" else ENVIRONMENTS[self.environment]
        return self.strength * np.reshape(given, (9, 3))

    @property
    def even(self) -> bool:
        """Whether the environment is the same from everywhere, so that no direction need be known."""
        return not self.sky[1:].any()

    @property
    def casts(self) -> bool:
        """Whether there is a shadow map."""
        return self.shadows and (self.lamps == "scene" or self.intensity > 0)

    @property
    def bounces(self) -> bool:
        """Whether light is gathered that bounced."""
        return self.indirect == "bitmask" or self.gathers

    @property
    def gathers(self) -> bool:
        """Whether it is gathered by a pass beside occlusion."""
        return self.indirect in GATHERED

    @property
    def lamp_slots(self) -> int:
        """Lamps that the shader has room for."""
        return MOST_LAMPS if self.lamps == "scene" else int(self.intensity > 0)

    def settled(self, scene: Scene) -> Light:
        """Return this light without shadows that no lamp of ``scene`` would cast. Raises SettingsError where it has to be lit by its own lamps and has none."""
        if self.lamps == "scene" and not scene.lamps:
            raise SettingsError(f"light: {scene.name or 'the scene'} has no lights of its own; use --light azimuth,elevation")
        sun = self.lamps == "key" or any(lamp.kind == "directional" for lamp in scene.lamps)
        if self.indirect == "rsm" and not sun:
            raise SettingsError(
                f"indirect=rsm: no lamp of {scene.name or 'the scene'} is directional; use --light azimuth,elevation"
            )
        return self if sun or not self.shadows else dataclasses.replace(self, shadows=False)


def lit_view(light: Light | None, scene: Scene, camera: Camera, size: Size) -> LitView:
    """Return the light of a scene as a camera sees it. ``size``: of the image."""
    if light is None:
        return LitView()
    level = _level_axes(np.asarray(scene.up, np.float64))
    values: dict[str, Any] = {
        "u_sky": FloatTable.of(light.sky),
        "u_sky_even": tuple(light.sky[0].tolist()),
        "u_sky_from_view": _columns(level.T @ camera.pose[:3, :3]),
    }
    lamps = _lamps(light, scene, camera, level)
    if light.lamp_slots:
        values |= _lamp_values(lamps, light.lamp_slots, camera)
    if not light.casts:
        return LitView(values)
    side = light.shadow_side
    sun = shadow_camera(-np.asarray(lamps[0].direction), scene.bounds, camera, size, side)
    view = sun.view((side, side))
    values |= _shadow_values(sun, view, camera) | {"u_shadow_light": lamps[0].color}
    return LitView(values, {SHADOW_EYE: (sun, view)})


def _columns(matrix: NDArray[np.float64]) -> tuple[float, ...]:
    """Return a matrix column by column."""
    return tuple(matrix.T.ravel().tolist())


def _level_axes(up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes (3, 3 by columns) of a world whose y points up: side, up, front, as automatic cameras have them."""
    up = up / np.linalg.norm(up)
    side = np.cross(up, [0, 0, 1] if abs(up[2]) < 0.9 else [0, -1, 0])
    side /= np.linalg.norm(side)
    return np.column_stack([side, up, np.cross(side, up)])


def _lamps(light: Light, scene: Scene, camera: Camera, level: NDArray[np.float64]) -> list[Lamp]:
    """Return the lamps that shine, the one that casts shadows first."""
    if light.lamps == "key":
        return [_key(light, camera, level)] if light.intensity > 0 else []
    middle = scene.bounds.mean(0)
    by_light = sorted(scene.lamps, key=lambda lamp: (lamp.kind != "directional", -lamp.reaches(middle)))[:MOST_LAMPS]
    # Files count in lux, in watts, or in nothing: the brightest is as bright as the key light would be.
    brightest = max((lamp.reaches(middle) for lamp in by_light), default=0.0)
    scale = light.intensity / brightest if brightest > 0 else 0.0
    return [lamp.brighter(scale) for lamp in by_light]


def _key(light: Light, camera: Camera, level: NDArray[np.float64]) -> Lamp:
    azimuth, elevation = math.radians(light.azimuth), math.radians(light.elevation)
    if light.follows == "camera":
        x, _, z = level.T @ camera.pose[:3, 2]  # backwards
        if math.hypot(x, z) < 1e-6:  # straight down, or up: what is below in the image is nearest to the viewer
            x, _, z = level.T @ (-camera.pose[:3, 1] * np.sign(camera.pose[:3, 2] @ level[:, 1]))
        azimuth += math.atan2(x, z)
    flat = math.cos(elevation)
    towards = level @ [flat * math.sin(azimuth), math.sin(elevation), flat * math.cos(azimuth)]
    r, g, b = (light.intensity * part for part in linear_rgb(light.color))
    x, y, z = (-towards).tolist()
    return Lamp("directional", (r, g, b), direction=(x, y, z), name="key")


def _lamp_values(lamps: list[Lamp], slots: int, camera: Camera) -> dict[str, Any]:
    """Return the uniforms of lamps, in view space."""
    place, color, axis = (np.zeros((slots, 4)) for _ in range(3))
    for i, lamp in enumerate(lamps):
        direction = camera.pose[:3, :3].T @ lamp.direction
        endless = lamp.kind == "directional"
        place[i] = (*-direction, 0) if endless else (*camera.pose[:3, :3].T @ (lamp.place - camera.pose[:3, 3]), 1)
        color[i] = (*lamp.color, 0 if lamp.range is None else lamp.range**-2)
        inner, outer = np.cos(lamp.cone)
        axis[i] = (
            (*direction / max(inner - outer, 1e-4), -outer / max(inner - outer, 1e-4)) if lamp.kind == "spot" else (0, 0, 0, 1)
        )
    return {"u_lamp_place": FloatTable.of(place), "u_lamp_color": FloatTable.of(color), "u_lamp_axis": FloatTable.of(axis)}


def _shadow_values(sun: Camera, view: ViewConstants, camera: Camera) -> dict[str, Any]:
    """Return the uniforms of the shadow map: where a view-space point lies in it, in texels and depth, and a texel's sides in view space."""
    side = view.size[0]
    to_map = np.eye(4)
    to_map[:2] = side / 2 * view.projection[:2]
    to_map[:2, 3] += side / 2
    to_map[2] = (0, 0, -1, 0)
    texel = 2 / (side * np.diag(view.projection)[:2])
    sides = camera.pose[:3, :3].T @ (sun.pose[:3, :2] * texel)
    return {
        "u_shadow_place": _columns(to_map @ np.linalg.inv(sun.pose) @ camera.pose),
        "u_shadow_sides": (*sides[:, 0].tolist(), *sides[:, 1].tolist()),
        "u_shadow_texel": float(texel.max()),
    }
