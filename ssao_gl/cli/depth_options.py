"""What ``ssao-gl apply`` is told of a depth image and its lens."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError, warn_of_input
from ..io import images
from ..io.depth_files import load_depth
from ..loaders.camera_files import load_camera
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.projection import Size
from .options import angle
from .output import parse_size


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class DepthOptions:
    """What is seen, and through which lens."""

    depth: Annotated[
        Path,
        Parameter(
            help="Depth, (h, w): NPY, NPZ, EXR, PFM, TIFF, or 16-bit PNG or PGM with --depth-scale; 0, inf, nan and one far constant are background."
        ),
    ]
    normals: Annotated[
        Path | None,
        Parameter(help="View-space normals, NPY or EXR (h, w, 3), or PNG as 0.5 + 0.5 n. [default: rebuilt from depth]"),
    ] = None
    depth_kind: Annotated[
        str,
        Parameter(
            help="eye (distance along the view axis), window (depth buffer, 0..1), ray (distance from the eye) or vtk (negative)."
        ),
    ] = "eye"
    depth_scale: Annotated[
        float | None,
        Parameter(help="Scene units per unit of depth; 0.001 reads millimetres as metres. [default: 1 for floats]"),
    ] = None
    depth_channel: Annotated[
        str | None, Parameter(help="Channel of an EXR file, or array of an NPZ file. [default: Z or V, of any layer]")
    ] = None
    depth_background: Annotated[
        float | None,
        Parameter(
            help="A stored value that is no surface; nan: no far constant is taken for background. [default: one far constant]",
            allow_leading_hyphen=True,
        ),
    ] = None
    depth_mask: Annotated[
        Path | None, Parameter(help="Picture or array of the depth's size, not 0 where there is a surface. [default: none]")
    ] = None
    depth_noise: Annotated[
        float,
        Parameter(
            help="Standard deviation of a sensor's depth at distance 1, growing with its square; is smoothed by planes. 0: exact."
        ),
    ] = 0.0
    yfov_deg: Annotated[
        float | None, Parameter(help="Vertical field of view, degrees. [this, --intrinsics or --ortho is needed]")
    ] = None
    intrinsics: Annotated[
        str | None, Parameter(help="fx,fy,cx,cy in pixels, as OpenCV gives them. [likewise]", allow_leading_hyphen=True)
    ] = None
    intrinsics_size: Annotated[
        str | None, Parameter(help="Width x height of the image that --intrinsics is for. [default: the image's own]")
    ] = None
    camera: Annotated[
        str | None,
        Parameter(
            help="Camera file, FILE or FILE:NAME, in place of these: .cam.json, NeRF's, COLMAP's or BOP's; its pose does not matter. [likewise]"
        ),
    ] = None
    ortho: Annotated[float | None, Parameter(help="Parallel projection this many scene units high. [likewise]")] = None
    znear: Annotated[float, Parameter(help="Near plane, scene units; matters for window depth.")] = 0.01
    zfar: Annotated[float, Parameter(help="Far plane, scene units; inf for none.")] = math.inf

    strict: Annotated[
        bool, Parameter(help="Take it for an error when something is dropped, guessed or converted.", negative="")
    ] = False

    def read(self, color: NDArray[np.uint8] | None) -> tuple[Camera, DepthImage]:
        """Return the camera, and the depth as settled for it. Raises FormatError, SettingsError."""
        form = {
            "kind": self.depth_kind,
            "scale": self.depth_scale,
            "background": self.depth_background,
            "noise": self.depth_noise,
        }
        DepthImage(np.ones((1, 1)), **form)  # type: ignore[arg-type]  # is checked before anything is read
        self._check_lens_options()
        values = load_depth(self.depth, self.depth_channel)
        if values.dtype.kind != "f" and self.depth_scale is None and self.depth_kind != "window":
            raise FormatError(
                f"{self.depth}: holds {values.dtype}; depth must be floats, or say how many scene units one step is:"
                " --depth-scale 0.001 for millimetres"
            )
        mask = None if self.depth_mask is None else _mask(self.depth_mask)
        try:
            image = DepthImage(values, mask=mask, **form)  # type: ignore[arg-type]
            camera = self._camera(image.size, image.size if color is None else (color.shape[1], color.shape[0]))
            return camera, DepthImage.settled(image.linear(camera))
        except FormatError as error:
            raise FormatError(f"{self.depth}: {error}") from None

    def _check_lens_options(self) -> None:
        """Raise SettingsError unless there is one lens."""
        if sum(x is not None for x in (self.yfov_deg, self.intrinsics, self.ortho, self.camera)) != 1:
            raise SettingsError(
                "say how the depth was seen: one of --yfov-deg, --intrinsics fx,fy,cx,cy, --ortho HEIGHT or --camera FILE"
            )
        if self.intrinsics_size is not None and self.intrinsics is None:
            raise SettingsError("--intrinsics-size: goes with --intrinsics")

    def _camera(self, size: Size, shown: Size) -> Camera:
        """Return the camera of a depth image of ``size`` (width, height) below colour of the size ``shown``. Raises SettingsError."""
        far = None if self.zfar == math.inf else self.zfar
        if self.camera is not None:
            return load_camera(self.camera, size)
        if self.yfov_deg is not None:
            return Camera.perspective(angle("--yfov-deg", self.yfov_deg), self.znear, far)
        if self.ortho is not None:
            return Camera.orthographic(self.ortho, self.znear, far if far is not None else 1e6 * self.ortho)
        try:
            fx, fy, cx, cy = (float(part) for part in str(self.intrinsics).split(","))
        except ValueError:
            raise SettingsError(f"--intrinsics {self.intrinsics}: must be fx,fy,cx,cy in pixels") from None
        if self.intrinsics_size is not None:
            seen = parse_size(self.intrinsics_size, "--intrinsics-size")
        else:
            seen = _likelier((cx, cy), size, shown)
        camera = Camera.pinhole(fx, fy, cx, cy, seen, znear=self.znear, zfar=far)
        _check_lens((cx, cy), seen, size)
        return camera


def _likelier(center: tuple[float, float], size: Size, shown: Size) -> Size:
    """Return which of two sizes has its middle nearer to ``center``; warns where that is a guess."""
    if size == shown:
        return size
    off = [abs(center[0] / w - 0.5) + abs(center[1] / h - 0.5) for w, h in (size, shown)]
    seen = size if off[0] <= off[1] else shown
    whose = "depth" if seen == size else "color"
    warn_of_input(
        f"--intrinsics are taken to be for {seen[0]}x{seen[1]}, as {whose} is; --intrinsics-size says for which image they are"
    )
    return seen


def _check_lens(center: tuple[float, float], seen: Size, size: Size) -> None:
    """Warn of intrinsics that seem to be those of another image."""
    if not (0 < center[0] < seen[0] and 0 < center[1] < seen[1]):
        text = f"--intrinsics: the middle {center[0]:g},{center[1]:g} lies outside {seen[0]}x{seen[1]}; --intrinsics-size says for which image they are"
        warn_of_input(text)
    if abs(seen[0] * size[1] / (seen[1] * size[0]) - 1) > 0.02:
        text = f"--intrinsics-size {seen[0]}x{seen[1]}: the image, {size[0]}x{size[1]}, has other proportions; pixels are taken to be stretched"
        warn_of_input(text)


def _mask(path: Path) -> NDArray[Any]:
    """Return a mask (h, w). Raises FormatError."""
    array = images.load_image(path)
    return np.asarray(array[..., :3].any(-1) if array.ndim == 3 else array != 0)
