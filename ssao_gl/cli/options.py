"""Options that several commands share, as dataclasses; what they mean in terms of settings and cameras."""

from __future__ import annotations

import dataclasses
import math
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..errors import SceneError, SettingsError
from ..loaders.load import load_scene
from ..methods.registry import registry
from ..passes.denoise import FILTERS
from ..pipeline.presets import read_toml, settings_from
from ..pipeline.settings import CULLING_RULES, Settings, Shading
from ..scene.camera import Camera
from ..scene.lens import Lens, Orthographic, Perspective
from ..scene.model import Scene
from ..scene.pose import look_at
from ..scene.projection import Matrix, Size
from ..settings import limits, title
from .output import input_warnings, parse_size, parse_vector


def _option(text: str) -> Parameter:
    # Numbers may be negative, and x,y,z that begin with a minus are no option.
    return Parameter(help=text, negative="", allow_leading_hyphen=True)


@Parameter(name="*", group="Occlusion")
@dataclass(frozen=True, kw_only=True)
class LookOptions:
    """Which method, which filter, and their settings."""

    method: Annotated[str | None, _option("AO method; `ssao-gl methods` lists them. [default: bitmask]")] = None
    preset: Annotated[
        str | None, _option("How much time for how little error: draft, low, medium, high or ultra. [default: medium]")
    ] = None
    radius: Annotated[
        float | None,
        _option("Reach of occlusion, scene units. [default: the camera file's ao_radius, else a share of the scene]"),
    ] = None
    samples: Annotated[int | None, _option("Taps a pixel. [default: the method's]")] = None
    blur: Annotated[str | None, _option("Filter: none, lecture, separable or joint. [default: joint]")] = None
    set: Annotated[
        tuple[str, ...],
        Parameter(
            name="--set",
            help="Any setting below, as key=value or group.key=value; may be repeated.",
            negative="",
            show_default=False,
        ),
    ] = ()
    keep: Annotated[
        tuple[str, ...],
        Parameter(
            name="--keep",
            help=f"A rule of leaving out to switch off: {', '.join(CULLING_RULES)}.",
            negative="",
            show_default=False,
        ),
    ] = ()
    keep_all: Annotated[bool, Parameter(name="--keep-all", help="Leave nothing out.", negative="", show_default=False)] = False
    config: Annotated[Path | None, _option("TOML file with settings. [default: none]")] = None

    def settings(self) -> Settings:
        """Return the settings that the options ask for. Raises SettingsError."""
        table = read_toml(self.config) if self.config else {}
        return settings_from(
            table,
            method_name=self.method,
            preset_name=self.preset,
            blur_name=self.blur,
            assignments=self.set,
            overrides={"radius": self.radius, "samples": self.samples},
            keep=["all"] if self.keep_all else self.keep,
        )


@Parameter(name="*", group="View")
@dataclass(frozen=True, kw_only=True)
class ViewOptions:
    """Size and camera."""

    size: Annotated[str, _option("Width x height, pixels.")] = "1280x720"
    camera: Annotated[
        str | None,
        _option(
            "Camera file, FILE or FILE:NAME: .cam.json, NeRF's, COLMAP's or BOP's. [default: the scene's own, else automatic]"
        ),
    ] = None
    eye: Annotated[str | None, _option("Where the camera stands: x,y,z in scene units. [default: the camera's]")] = None
    target: Annotated[
        str | None,
        _option("What it looks at: x,y,z in scene units. [default: the camera's; the middle of the scene with --eye or --up]"),
    ] = None
    up: Annotated[
        str | None,
        _option("Upwards in the image: a direction x,y,z. [default: the camera's; the scene's up with --eye or --target]"),
    ] = None
    yfov_deg: Annotated[
        float | None, _option("Vertical field of view, degrees. [default: the camera's; 40 for an automatic one]")
    ] = None
    znear: Annotated[
        float | None, _option("Distance of the near plane, scene units. [default: the camera's; by the scene with --eye]")
    ] = None
    zfar: Annotated[float | None, _option("Distance of the far plane, scene units; inf for none. [default: likewise]")] = None
    ortho: Annotated[
        float | None, _option("Parallel projection this many scene units high. [default: the camera's projection]")
    ] = None
    up_axis: Annotated[str, _option("Which axis of the file is up, for automatic views: x, y, z or auto.")] = "auto"
    crease_deg: Annotated[float, _option("Meshes without normals: edges sharper than this stay sharp, degrees; 0: flat.")] = (
        40.0
    )
    animation: Annotated[
        str | None, _option("Animation of a glTF file, by name or number. [default: none, the file's rest pose]")
    ] = None
    time: Annotated[float, _option("Moment of --animation, seconds.")] = 0.0
    point_size: Annotated[
        float | None, _option("Diameter of points, scene units. [default: one that closes their surface]")
    ] = None
    strict: Annotated[
        bool, _option("Take it for an error when something of the scene or camera file is dropped or guessed.")
    ] = False

    def pixels(self) -> Size:
        """(width, height). Raises SettingsError."""
        return parse_size(self.size)

    def load(self, path: Path | None) -> Scene:
        """Return the scene file, or the embedded scene. Raises SceneError, SettingsError."""
        if path is None:
            from ..scene.sample_scene import default_scene

            return default_scene()
        if not 0 <= self.crease_deg <= 180:
            raise SettingsError(f"--crease-deg {self.crease_deg:g}: must be 0 to 180")
        if self.point_size is not None and not 0 < self.point_size < math.inf:
            raise SettingsError(f"--point-size {self.point_size:g}: must be above 0 (scene units)")
        scene = load_scene(
            path, crease=math.radians(self.crease_deg), up=self.up_axis,
            animation=self.animation, time=self.time, point_size=self.point_size,
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
        if self.eye is not None or self.target is not None or self.up is not None:
            eye = pose[:3, 3] if self.eye is None else parse_vector("eye", self.eye)
            target = scene.bounds.mean(0) if self.target is None else parse_vector("target", self.target)
            up = scene.up if self.up is None else parse_vector("up", self.up)
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
    Parameter(name="--gl", group="Output", help="OpenGL provider: auto, egl-es, egl-gl, osmesa, angle, swiftshader, native."),
]
JsonOption = Annotated[
    Path | None,
    Parameter(
        name="--json",
        group="Output",
        help="Write settings, plan, renderer and milliseconds per pass to this file; - prints them. [default: none]",
        allow_leading_hyphen=True,
    ),
]


def settings_help() -> str:
    """Every setting with unit, default and range, from the dataclasses themselves."""
    groups = [Settings, *registry().values(), *FILTERS.values(), Shading]
    lines = ["Settings for --set and TOML files (group.key, default, unit, range):"]
    for kind in groups:
        prefix = f"blur.{title(kind)}" if kind in FILTERS.values() else title(kind)
        lines.append(f"  {prefix if kind is not Settings else '(no group)'}")
        for field in (f for f in dataclasses.fields(kind) if "limits" in f.metadata):  # type: ignore[arg-type]
            rule = limits(field)
            facts = ", ".join(
                part for part in (f"{'auto' if field.default is None else field.default}", rule.unit, rule.describe()) if part
            )
            lines.append(f"    {field.name:14}{rule.doc} [{facts}]")
    return "\n".join(lines)
