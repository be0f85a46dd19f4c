"""Options that several commands share, as dataclasses; what they mean in terms of settings and cameras."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..errors import SceneError, SettingsError
from ..loaders.load import load_scene
from ..loaders.up_axis import AXES, up_direction
from ..pipeline.presets import as_rays, read_toml, settings_from, settings_toml
from ..pipeline.settings import CULLING_RULES, Settings
from ..scene.camera import Camera
from ..scene.lens import Lens, Orthographic, Perspective
from ..scene.model import Scene
from ..scene.pose import look_at
from ..scene.projection import Matrix, Size
from ..settings import assign
from .help_pages import OCCLUSION, OUTPUT, RARE, VIEW
from .light_options import LightOptions
from .molecule_options import AtomOptions
from .output import check_output, check_radius, input_warnings, parse_size, parse_vector, write_text
from .tokens import WHOLE, parse_share
from .volume_options import VoxelOptions


def _option(text: str, *, rare: bool = False) -> Parameter:
    # Numbers may be negative, and x,y,z that begin with a minus are no option.
    plain = Parameter(help=text, negative="", allow_leading_hyphen=True)
    return Parameter.combine(plain, Parameter(group=RARE)) if rare else plain


@Parameter(name="*", group=OCCLUSION)
@dataclass(frozen=True, kw_only=True)
class LookOptions:
    """Which method, which filter, and their settings."""

    method: Annotated[str | None, _option("One of `ssao-gl methods`. [default: bitmask]")] = None
    preset: Annotated[
        str | None, _option("How much time for how little error: draft, low, medium, high or ultra. [default: medium]")
    ] = None
    radius: Annotated[
        str | None,
        _option(
            "Reach, in scene units or as a share of the scene's size, like 10%. [default: the camera file's ao_radius, else 3%]"
        ),
    ] = None
    samples: Annotated[int | None, WHOLE, _option("Taps a pixel, where counted. [default: the method's]")] = None
    blur: Annotated[str | None, _option("none, lecture, separable or joint. [default: joint]")] = None
    rays: Annotated[
        str | None,
        _option(
            "Rays a pixel that correct what the screen cannot know, any share of one, like 0.25; needs the extra truth. [default: 0]",
            rare=True,
        ),
    ] = None
    set: Annotated[
        tuple[str, ...],
        Parameter(
            name="--set",
            help="Any setting of the method, as key=value, or of another group, as group.key=value; may be repeated.",
            negative="",
            show_default=False,
        ),
    ] = ()
    keep: Annotated[
        tuple[str, ...],
        Parameter(
            name="--keep",
            group=RARE,
            help=f"A rule of leaving out to switch off: {', '.join(CULLING_RULES)}.",
            negative="",
            show_default=False,
        ),
    ] = ()
    keep_all: Annotated[
        bool, Parameter(name="--keep-all", group=RARE, help="Leave nothing out.", negative="", show_default=False)
    ] = False
    halo: Annotated[
        float | None,
        _option("Halo around what is in front of something else: its strength, 0 to 1. [default: none]", rare=True),
    ] = None
    halo_color: Annotated[str | None, _option("Of --halo: #rrggbb, white or black. [default: black]", rare=True)] = None
    exclude: Annotated[
        tuple[str, ...],
        Parameter(
            name="--exclude",
            group=RARE,
            help="Name of a thing or material that receives no occlusion; NAME:casts: that casts none. May be repeated.",
            negative="",
            show_default=False,
        ),
    ] = ()
    config: Annotated[Path | None, _option("TOML file with settings. [default: none]")] = None
    dump_config: Annotated[
        Path | None,
        _option("Write all settings to this TOML file, for --config. [default: none]", rare=True),
    ] = None

    def settings(self) -> Settings:
        """Return the settings that the options ask for. Raises SettingsError."""
        if self.dump_config is not None:
            check_output("--dump-config", self.dump_config, (".toml",))
        table = read_toml(self.config) if self.config else {}
        settings = settings_from(
            table,
            method_name=self.method,
            preset_name=self.preset,
            blur_name=self.blur,
            assignments=(*self.set, *self._halo()),
            overrides={"samples": self.samples},
            keep=["all"] if self.keep_all else self.keep,
            rays=None if self.rays is None else as_rays(self.rays),
        )
        if self.exclude:
            settings = dataclasses.replace(settings, exclude=self.exclude)
        if self.radius is None:
            return settings
        share = parse_share(self.radius)
        radius = check_radius(self.radius) if share is None else f"{share!r}"
        if share is not None and settings.method.traits.radius_unit == "scene units":
            radius = "auto"  # until the scene is known: settled() does it
        return dataclasses.replace(settings, method=assign(settings.method, {"radius": radius}))

    def _halo(self) -> list[str]:
        """Return the assignments that ``--halo`` and ``--halo-color`` stand for."""
        given = {"shading.halo": self.halo, "shading.halo_color": self.halo_color}
        return [f"{key}={value}" for key, value in given.items() if value is not None]

    def dump(self, settings: Settings, drawn: Mapping[str, Any] | None = None) -> None:
        """Write what ``--dump-config`` asks for. ``drawn``: the table of settings that were chosen for a target. Raises FormatError."""
        if self.dump_config is not None:
            write_text(self.dump_config, settings_toml(drawn or settings.table()))

    def settled(self, settings: Settings, length: Callable[[float], float]) -> Settings:
        """Return settings with a radius that was given as a share. ``length``: of a share of the scene, scene units."""
        share = parse_share(self.radius or "")
        return settings if share is None else settings.with_radius(length(share))


@Parameter(name="*", group=OCCLUSION)
@dataclass(frozen=True, kw_only=True)
class LitLookOptions(LookOptions):
    """Which method and filter, their settings, and light: of commands that draw scenes."""

    lit: LightOptions = LightOptions()

    def settings(self) -> Settings:
        """Return the settings that the options ask for. Raises SettingsError, FormatError."""
        return self.lit.onto(LookOptions.settings(self))


@Parameter(name="*", group=VIEW)
@dataclass(frozen=True, kw_only=True)
class ViewOptions:
    """Size and camera."""

    size: Annotated[str, _option("Width x height, pixels.")] = "1280x720"
    camera: Annotated[
        str | None,
        _option("FILE or FILE:NAME: .cam.json, NeRF, COLMAP or BOP. [default: the scene's own, else automatic]"),
    ] = None
    eye: Annotated[str | None, _option("Where the camera stands, x,y,z. [default: the camera's]")] = None
    target: Annotated[
        str | None,
        _option("What it looks at: x,y,z in scene units. [default: the camera's; the middle of the scene with --eye or --up]"),
    ] = None
    up: Annotated[
        str | None,
        _option(
            "What is up: an axis of the file, x, y or z, or a direction x,y,z of the image. [default: the camera's, or by format]"
        ),
    ] = None
    yfov_deg: Annotated[
        float | None, _option("Vertical field of view, degrees. [default: the camera's; 40 for an automatic one]")
    ] = None
    znear: Annotated[
        float | None,
        _option("Distance of the near plane, scene units. [default: the camera's; by the scene with --eye]", rare=True),
    ] = None
    zfar: Annotated[
        float | None, _option("Distance of the far plane, scene units; inf for none. [default: likewise]", rare=True)
    ] = None
    ortho: Annotated[
        float | None, _option("Parallel projection this many scene units high. [default: the camera's projection]")
    ] = None
    up_axis: Annotated[str, _option("Which axis of the file is up, for automatic views: x, y, z or auto.", rare=True)] = "auto"
    crease_deg: Annotated[
        float, _option("Meshes without normals: edges sharper than this stay sharp, degrees; 0: flat.", rare=True)
    ] = 40.0
    animation: Annotated[
        str | None, _option("Animation of a glTF file, by name or number. [default: none, the file's rest pose]", rare=True)
    ] = None
    time: Annotated[float, _option("Moment of --animation, seconds.", rare=True)] = 0.0
    point_size: Annotated[
        float | None, _option("Diameter of points, scene units. [default: one that closes their surface]", rare=True)
    ] = None
    atoms: AtomOptions = AtomOptions()
    voxels: VoxelOptions = VoxelOptions()
    strict: Annotated[
        bool, _option("Take it for an error when something of the scene or camera file is dropped or guessed.", rare=True)
    ] = False

    def pixels(self) -> Size:
        """(width, height). Raises SettingsError."""
        return parse_size(self.size)

    def load(self, path: Path | None) -> Scene:
        """Return the scene file, or the embedded scene. Raises SceneError, SettingsError."""
        axis = self.up if self.up is not None and self.up in AXES else self.up_axis
        if path is None:
            from ..scene.sample_scene import default_scene

            scene = default_scene()
            return scene if axis == "auto" else dataclasses.replace(scene, up=up_direction(axis))
        if not 0 <= self.crease_deg <= 180:
            raise SettingsError(f"--crease-deg {self.crease_deg:g}: must be 0 to 180")
        if self.time and self.animation is None:
            raise SettingsError(f"--time {self.time:g}: is the moment of an animation; add --animation NAME")
        if self.point_size is not None and not 0 < self.point_size < math.inf:
            raise SettingsError(f"--point-size {self.point_size:g}: must be above 0 (scene units)")
        scene = load_scene(
            path, crease=math.radians(self.crease_deg), up=axis,
            animation=self.animation, time=self.time, point_size=self.point_size,
            molecule=self.atoms.molecule(), volume=self.voxels.volume(),
        )  # fmt: skip
        if self.strict and scene.warnings:
            raise SceneError(f"{path}: {scene.warnings[0]} (--strict)")
        return scene

    def choose(self, scene: Scene) -> Camera:
        """Return the camera for ``scene``: the options' over the file's over the scene's over an automatic one."""
        size = self.pixels()
        if self.camera is not None:
            from ..loaders.camera_files import load_camera

            with input_warnings(strict=True) if self.strict else nullcontext():
                base = load_camera(self.camera, size)
        else:
            base = scene.cameras[0] if scene.cameras else scene.default_camera(size)
        pose = base.pose
        automatic = self.camera is None and not scene.cameras
        turned = self.up is not None and not (automatic and self.up in AXES)  # an axis is in the scene already
        if self.eye is not None or self.target is not None or turned:
            eye = pose[:3, 3] if self.eye is None else parse_vector("eye", self.eye)
            target = scene.bounds.mean(0) if self.target is None else parse_vector("target", self.target)
            up = scene.up if self.up is None or self.up in AXES else parse_vector("up", self.up)
            pose = look_at(eye, target, up)
        return dataclasses.replace(base, lens=self._lens(base, scene, pose), pose=pose)

    def _lens(self, base: Camera, scene: Scene, pose: Matrix) -> Lens:
        """Return the base's lens, changed only where an option asks for it."""
        if self.ortho is not None and self.yfov_deg is not None:
            raise SettingsError("--ortho and --yfov-deg exclude each other: a parallel projection has no angle")
        moved = not np.array_equal(pose, base.pose) and self.camera is None
        if self.ortho is None and self.yfov_deg is None and self.znear is None and self.zfar is None and not moved:
            return base.lens
        corners = np.array([[x, y, z] for x in scene.bounds[:, 0] for y in scene.bounds[:, 1] for z in scene.bounds[:, 2]])
        depths = (pose[:3, 3] - corners) @ pose[:3, 2]
        view = base.view(self.pixels())
        near = self.znear if self.znear is not None else (max(1e-4 * scene.extent, 0.5 * depths.min()) if moved else view.near)
        far = self.zfar if self.zfar is not None else (max(1.5 * depths.max(), 2 * near) if moved else view.far)
        height = self.ortho
        if height is None and self.yfov_deg is None and isinstance(base.lens, Orthographic):
            height = base.lens.height
        if height is not None:
            return Orthographic(height, self.znear or 0.0, 1e6 * height if far == math.inf else far)
        yfov = 2 * math.atan(1 / abs(view.projection[1, 1])) if self.yfov_deg is None else angle("--yfov-deg", self.yfov_deg)
        return Perspective(yfov, near, None if far == math.inf else far)


def angle(name: str, degrees: float) -> float:
    """Return a field of view in radians. Raises SettingsError."""
    if not 0 < degrees < 180:
        raise SettingsError(f"{name} {degrees:g}: must lie between 0 and 180 degrees")
    return math.radians(degrees)


GlOption = Annotated[
    str,
    Parameter(name="--gl", group=RARE, help="OpenGL provider: auto, egl-es, egl-gl, osmesa, angle, swiftshader, native."),
]
JsonOption = Annotated[
    Path | None,
    Parameter(
        name="--json",
        group=OUTPUT,
        help="Write a report to this file; - prints it. [default: none]",
        allow_leading_hyphen=True,
    ),
]
