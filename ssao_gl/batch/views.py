"""Where cameras come from: files, paths through some of them, and generators that look at a scene from around it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from ..errors import SceneError, SettingsError, near_miss
from ..loaders.camera_files import load_camera, load_cameras
from ..loaders.load import load_scene
from ..sampling.disk import GOLDEN_ANGLE
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from .clearance import cleared
from .paths import along

MOST_VIEWS = 1_000_000
GENERATORS = ("orbit", "sphere", "path", "own")
ELEVATION = 0.45
"""Of an orbit above the horizon, radians: that of automatic cameras."""


class View(Protocol):
    """A camera that may have to know its scene."""

    @property
    def name(self) -> str:
        """What it is called among the views of a scene."""

    @property
    def facts(self) -> list[Any]:
        """All that decides the camera beside the scene and the size, as JSON values."""

    def camera(self, scene: Scene, size: Size) -> Camera:
        """Return the camera for a scene and the size of an image."""


@dataclass(frozen=True)
class Around:
    """How a generator looks at a scene.

    distance: as a multiple of that from which the whole scene is seen. keep_away: least distance of the eye from surfaces, as
    a share of the scene's diagonal; nearer eyes are moved out or in. seed: turns the pattern. Raises SettingsError.
    """

    distance: float = 1.0
    keep_away: float = 0.01
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0 < self.distance < math.inf:
            raise SettingsError(f"distance={self.distance:g}: must be above 0, as a multiple of what shows the whole scene")
        if not 0 <= self.keep_away <= 1:
            raise SettingsError(f"keep_away={self.keep_away:g}: must be 0 to 1, as a share of the scene's diagonal")


@dataclass(frozen=True, eq=False)
class GivenView:
    """A camera of a file; without one, the scene's own first camera or an automatic one."""

    given: Camera | None = None
    name: str = "view"

    @property
    def facts(self) -> list[Any]:
        return ["given", self.given and [self.given.to_json(), self.given.pose.tolist()]]

    def camera(self, scene: Scene, size: Size) -> Camera:
        return self.given or (scene.cameras[0] if scene.cameras else scene.default_camera(size)).named(self.name)


@dataclass(frozen=True)
class GeneratedView:
    """A camera of ``orbit`` (evenly around the scene's up axis) or ``sphere`` (a spherical Fibonacci lattice about it)."""

    kind: str
    index: int
    count: int
    around: Around

    @property
    def name(self) -> str:
        return f"{self.kind}_{self.index:0{max(4, len(str(self.count - 1)))}d}"

    @property
    def facts(self) -> list[Any]:
        return [self.kind, self.index, self.count, dataclasses.astuple(self.around)]

    def camera(self, scene: Scene, size: Size) -> Camera:
        azimuth, elevation = self._direction()
        camera = scene.default_camera(size, azimuth=azimuth, elevation=elevation)
        return cleared(camera.named(self.name), scene, self.around.distance, self.around.keep_away)

    def _direction(self) -> tuple[float, float]:
        """Return azimuth and elevation, radians. See Keinert et al., Spherical Fibonacci Mapping, 2015, for the lattice."""
        turned = self.around.seed * GOLDEN_ANGLE
        if self.kind == "orbit":
            return turned + 0.6 + 2 * math.pi * self.index / self.count, ELEVATION
        return turned + self.index * GOLDEN_ANGLE, math.asin(1 - (2 * self.index + 1) / self.count)


def views_of(spec: str | Camera | None, size: Size, around: Around, scene: Path) -> Sequence[View]:
    """Return the views that a word of ``--cameras`` stands for; ``scene`` is read only for ``own``.

    ``FILE``, ``FILE:NAME``, ``FILE:all``, ``orbit:N``, ``sphere:N``, ``path:FILE`` or ``path:FILE:N``, ``own`` (all of the scene file);
    None: one camera, the scene's own or an automatic one; a camera is itself. Raises SettingsError, SceneError.
    """
    if spec is None:
        return [GivenView()]
    if isinstance(spec, Camera):
        return _given([spec], "")
    kind, _, rest = spec.partition(":")
    if spec == "own":
        return _given(load_scene(scene).cameras, f"{scene}: has no cameras of its own; name others, like orbit:12")
    if kind in ("orbit", "sphere") and not Path(spec).exists():
        count = _count(spec, rest)
        return [GeneratedView(kind, index, count, around) for index in range(count)]
    if kind == "path" and not Path(spec).exists():
        file, _, number = rest.rpartition(":")
        counted = bool(file) and number.isascii() and number.isdigit()
        keys = load_cameras(file if counted else rest, size)
        return _given(along(keys, _count(spec, number) if counted else None, size), f"{spec}: no cameras")
    file, _, choice = spec.rpartition(":")
    if file and choice == "all" and not Path(spec).exists():
        return _given(load_cameras(file, size), f"{file}: has no cameras")
    if not Path(spec).exists() and not file:
        raise SceneError(
            f"cameras '{spec}': no such file; expected FILE, FILE:NAME, FILE:all, orbit:N, sphere:N, path:FILE or own."
            + near_miss(spec, GENERATORS)
        )
    if Path(spec).exists():
        return _given(load_cameras(spec, size), f"{spec}: has no cameras")
    return _given([load_camera(spec, size)], "")


def _given(cameras: Sequence[Camera], missing: str) -> Sequence[View]:
    if not cameras:
        raise SceneError(missing)
    width = max(4, len(str(len(cameras) - 1)))
    named = [camera if camera.name else camera.named(f"{index:0{width}d}") for index, camera in enumerate(cameras)]
    return [GivenView(camera, camera.name) for camera in named]


def _count(spec: str, text: str) -> int:
    if not (text.isascii() and text.isdigit() and 0 < int(text[:9]) <= MOST_VIEWS and len(text) < 9):
        raise SettingsError(
            f"cameras {spec}: expected a number of views from 1 to {MOST_VIEWS} behind the colon, like orbit:36"
        )
    return int(text)
