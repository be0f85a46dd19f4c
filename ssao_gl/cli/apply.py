"""``ssao-gl apply``: occlusion onto a picture that already exists."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError
from ..io import images
from ..planner import apply_planned
from ..render.renderer import Renderer
from ..scene.camera import Camera
from .options import GlOption, JsonOption, LookOptions, angle
from .output import check_json, check_output, say, write_json
from .plan_options import PlanOptions, compared

Array = NDArray[Any]


def apply(
    color: Path | None = None,
    *,
    depth: Annotated[
        Path,
        Parameter(
            help="Depth, NPY or EXR (h, w): distance along the view axis in scene units, 0 = background; or window depth 0..1."
        ),
    ],
    normals: Annotated[
        Path | None,
        Parameter(help="View-space normals, NPY or EXR (h, w, 3), or PNG as 0.5 + 0.5 n. [default: rebuilt from depth]"),
    ] = None,
    depth_kind: Annotated[str, Parameter(help="eye (scene units) or window (0..1).")] = "eye",
    yfov_deg: Annotated[
        float | None, Parameter(help="Vertical field of view, degrees. [this, --intrinsics or --ortho is needed]")
    ] = None,
    intrinsics: Annotated[
        str | None, Parameter(help="fx,fy,cx,cy in pixels, as OpenCV gives them. [likewise]", allow_leading_hyphen=True)
    ] = None,
    ortho: Annotated[float | None, Parameter(help="Parallel projection this many scene units high. [likewise]")] = None,
    znear: Annotated[float, Parameter(help="Near plane, scene units; matters for window depth.")] = 0.01,
    zfar: Annotated[float, Parameter(help="Far plane, scene units; inf for none.")] = math.inf,
    strength: Annotated[float, Parameter(help="0 leaves the colour as it is, 1 dims it by all of the occlusion.")] = 1.0,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group="Output", help="PNG, NPY or EXR file, or a folder for all AOVs.")
    ] = Path("ssao.png"),
    aov: Annotated[
        str | None,
        Parameter(
            group="Output",
            help="What to write to a single file: image, visibility, depth, normal or bent. [default: image for PNG with a COLOR, else visibility]",
        ),
    ] = None,
    gl: GlOption = "auto",
    json: JsonOption = None,
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
    settings = type(settings)(method=settings.method, blur=settings.blur, shading=type(settings.shading)(ambient=strength))
    check_output("-o", output, images.SUFFIXES, folder=True)
    check_json(json)
    seen, normal, picked = _read(color, depth, normals)
    h, w = seen.shape[:2]
    camera = _camera((w, h), yfov_deg, intrinsics, ortho, znear, zfar)
    aovs = ("visibility", "depth", "normal", *(("bent",) if aov == "bent" else ()))
    with Renderer(gl) as renderer:
        picture = apply_planned(
            renderer, seen, camera, target, settings, color=picked, normals=normal, depth_kind=depth_kind, aovs=aovs,
            timed=5 if json else 0,
        )  # fmt: skip
    if aov is None and output.suffix.lower() == ".png":
        aov = "image" if color else "visibility"
    paths = picture.save(output, aov=aov)
    if json:
        write_json(json, picture.report)
    method = picture.report["settings"]["method"]
    where = paths[0] if len(paths) == 1 else output
    say(f"{where}: {w}x{h}, {method}, {picture.report['provider']} ({picture.report['renderer']})", json)
    if "planned" in picture.report:
        say(compared(picture.report["planned"]), json)
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


def _camera(
    size: tuple[int, int], yfov_deg: float | None, intrinsics: str | None, ortho: float | None, znear: float, zfar: float
) -> Camera:
    if sum(x is not None for x in (yfov_deg, intrinsics, ortho)) != 1:
        raise SettingsError("say how the depth was seen: one of --yfov-deg, --intrinsics fx,fy,cx,cy or --ortho HEIGHT")
    far = None if zfar == math.inf else zfar
    if yfov_deg is not None:
        return Camera.perspective(angle("--yfov-deg", yfov_deg), znear, far)
    if ortho is not None:
        return Camera.orthographic(ortho, znear, far if far is not None else 1e6 * ortho)
    try:
        fx, fy, cx, cy = (float(part) for part in str(intrinsics).split(","))
    except ValueError:
        raise SettingsError(f"--intrinsics {intrinsics}: must be fx,fy,cx,cy in pixels") from None
    return Camera.pinhole(fx, fy, cx, cy, size, znear=znear, zfar=far)
