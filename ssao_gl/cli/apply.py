"""``ssao-gl apply``: occlusion onto a picture that already exists."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError
from ..io import images
from ..io.streams import output_suffix
from ..planner import apply_planned
from ..render.arrays import check_arrays, radius_of
from ..render.picture import Picture
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.projection import Size
from .help_pages import OUTPUT
from .options import GlOption, JsonOption, LookOptions, angle
from .output import check_json, check_output, say, write_json
from .plan_options import PlanOptions, compared

Array = NDArray[Any]
TIMED_FRAMES = 5


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class DepthOptions:
    """What is seen, and through which lens."""

    depth: Annotated[
        Path,
        Parameter(
            help="Depth, NPY or EXR (h, w): distance along the view axis in scene units, 0 = background; or window depth 0..1."
        ),
    ]
    normals: Annotated[
        Path | None,
        Parameter(help="View-space normals, NPY or EXR (h, w, 3), or PNG as 0.5 + 0.5 n. [default: rebuilt from depth]"),
    ] = None
    depth_kind: Annotated[str, Parameter(help="eye (scene units) or window (0..1).")] = "eye"
    yfov_deg: Annotated[
        float | None, Parameter(help="Vertical field of view, degrees. [this, --intrinsics or --ortho is needed]")
    ] = None
    intrinsics: Annotated[
        str | None, Parameter(help="fx,fy,cx,cy in pixels, as OpenCV gives them. [likewise]", allow_leading_hyphen=True)
    ] = None
    ortho: Annotated[float | None, Parameter(help="Parallel projection this many scene units high. [likewise]")] = None
    znear: Annotated[float, Parameter(help="Near plane, scene units; matters for window depth.")] = 0.01
    zfar: Annotated[float, Parameter(help="Far plane, scene units; inf for none.")] = math.inf

    def camera(self, size: Size) -> Camera:
        """Return the camera of an image of ``size`` (width, height). Raises SettingsError."""
        if sum(x is not None for x in (self.yfov_deg, self.intrinsics, self.ortho)) != 1:
            raise SettingsError("say how the depth was seen: one of --yfov-deg, --intrinsics fx,fy,cx,cy or --ortho HEIGHT")
        far = None if self.zfar == math.inf else self.zfar
        if self.yfov_deg is not None:
            return Camera.perspective(angle("--yfov-deg", self.yfov_deg), self.znear, far)
        if self.ortho is not None:
            return Camera.orthographic(self.ortho, self.znear, far if far is not None else 1e6 * self.ortho)
        try:
            fx, fy, cx, cy = (float(part) for part in str(self.intrinsics).split(","))
        except ValueError:
            raise SettingsError(f"--intrinsics {self.intrinsics}: must be fx,fy,cx,cy in pixels") from None
        return Camera.pinhole(fx, fy, cx, cy, size, znear=self.znear, zfar=far)


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class AppliedOptions:
    """What is written, and where."""

    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            allow_leading_hyphen=True,
            help="PNG, NPY or EXR file, - for a PNG on standard output, or a folder for all AOVs.",
        ),
    ] = Path("ssao.png")
    aov: Annotated[
        str | None,
        Parameter(
            help="What to write to a single file: image, visibility, depth, normal or bent. [default: image for PNG with a COLOR, else visibility]",
        ),
    ] = None
    json: JsonOption = None

    def check(self) -> None:
        """Raise FormatError for what cannot be written, before anything is drawn."""
        check_output("-o", self.output, images.SUFFIXES, folder=True)
        check_json(self.json)

    def save(self, picture: Picture, *, colored: bool) -> None:
        """Write what was asked for, and say where it is."""
        aov = self.aov
        if aov is None and output_suffix(self.output) == ".png":
            aov = "image" if colored else "visibility"
        paths = picture.save(self.output, aov=aov)
        report = picture.report
        if self.json:
            write_json(self.json, report)
        where, (w, h) = paths[0] if len(paths) == 1 else self.output, report["size"]
        say(f"{where}: {w}x{h}, {report['settings']['method']}, {report['provider']} ({report['renderer']})")
        if "planned" in report:
            say(compared(report["planned"]))


def apply(
    color: Path | None = None,
    *,
    given: DepthOptions,
    strength: Annotated[float, Parameter(help="0 leaves the colour as it is, 1 dims it by all of the occlusion.")] = 1.0,
    to: AppliedOptions = AppliedOptions(),
    gl: GlOption = "auto",
    look: LookOptions = LookOptions(),
    goal: PlanOptions = PlanOptions(),
) -> int:
    """Dim a picture by the occlusion of its depth.

    Parameters
    ----------
    color
        sRGB picture of the same size. Without it only visibility is made.
    """
    settings = look.settings()
    target = goal.target(look)  # is checked before anything is read
    if not 0 <= strength <= 1:
        raise SettingsError(f"--strength {strength:g}: must be 0 to 1")
    settings = dataclasses.replace(settings, shading=dataclasses.replace(settings.shading, ambient=strength))
    to.check()
    seen, normal, picked = _read(color, given.depth, given.normals)
    h, w = seen.shape[:2]
    camera = given.camera((w, h))
    settings = look.settled(
        settings, lambda share: radius_of(check_arrays(seen, None, None)[0], camera, given.depth_kind, share)
    )
    aovs = ("visibility", "depth", "normal", *(("bent",) if to.aov == "bent" else ()))
    with Renderer(gl) as renderer:
        picture = apply_planned(
            renderer, seen, camera, target, settings, color=picked, normals=normal, depth_kind=given.depth_kind, aovs=aovs,
            timed=TIMED_FRAMES if to.json else 0,
        )  # fmt: skip
    to.save(picture, colored=color is not None)
    look.dump(settings, picture.report["settings"] if target else None)
    return 0


def _read(color: Path | None, depth: Path, normals: Path | None) -> tuple[Array, Array | None, Array | None]:
    """Depth, normals and colour. Raises FormatError."""
    depth_array = images.load_image(depth)
    if depth_array.ndim == 3 and depth_array.shape[2] == 1:
        depth_array = depth_array[..., 0]
    if depth_array.dtype.kind != "f":
        raise FormatError(f"{depth}: holds {depth_array.dtype}; depth must be floats (NPY or EXR), in scene units")
    normal_array = None
    if normals is not None:
        normal_array = images.load_image(normals)
        if normal_array.dtype == np.uint8 and normal_array.ndim == 3:
            normal_array = normal_array[..., :3].astype(np.float32) / 127.5 - 1
    color_array = None
    if color is not None:
        color_array = images.load_image(color)
        if color_array.ndim == 2:
            color_array = np.repeat(color_array[..., None], 3, -1)
    return depth_array, normal_array, color_array
