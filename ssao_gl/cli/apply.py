"""``ssao-gl apply``: occlusion onto a picture that already exists."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ..errors import SettingsError
from ..io import images
from ..io.atomic import is_folder
from ..io.color_files import load_color
from ..io.streams import output_suffix
from ..pipeline.residual import check_no_scene
from ..planner import apply_planned
from ..render.arrays import radius_of
from ..render.picture import Picture
from ..render.renderer import Renderer
from .depth_options import DepthOptions
from .help_pages import OUTPUT
from .options import GlOption, JsonOption, LookOptions
from .output import check_json, check_output, input_warnings, say, write_json
from .plan_options import PlanOptions, compared

Array = NDArray[Any]
TIMED_FRAMES = 5


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

    def save(self, picture: Picture, told: Sequence[str], *, colored: bool) -> None:
        """Write what was asked for, and say where it is."""
        aov = self.aov
        if aov is None and output_suffix(self.output) == ".png":
            aov = "image" if colored else "visibility"
        paths = picture.save(self.output, aov=aov)
        report = picture.report
        if self.json:
            write_json(self.json, {**report, "warnings": [*report.get("warnings", ()), *told]})
        where = paths[0] if len(paths) == 1 else self.output
        h, w = picture.visibility.shape
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
        sRGB picture of the same size, or larger: results are then upsampled along its edges. Without it only visibility is made.
    """
    settings = look.settings()
    check_no_scene(settings, "apply")
    target = goal.target(look)  # is checked before anything is read
    if not 0 <= strength <= 1:
        raise SettingsError(f"--strength {strength:g}: must be 0 to 1")
    settings = dataclasses.replace(settings, shading=dataclasses.replace(settings.shading, ambient=strength))
    to.check()
    aovs = ("visibility", "depth", "normal", *(("bent",) if to.aov == "bent" else ()))
    with input_warnings(strict=given.strict) as told:
        picked = None if color is None else load_color(color)
        camera, seen = given.read(picked)
        normal = None if given.normals is None else _normals(given.normals)
        settings = look.settled(settings, lambda share: radius_of(seen.linear(camera), camera, "eye", share))
        with Renderer(gl) as renderer:
            picture = apply_planned(
                renderer, seen, camera, target, settings, color=picked, normals=normal, aovs=aovs,
                visibility_bits=8 if output_suffix(to.output) == ".png" and not is_folder(to.output) else 16,
                timed=TIMED_FRAMES if to.json else 0,
            )  # fmt: skip
    to.save(picture, told, colored=color is not None)
    look.dump(settings, picture.report["settings"] if target else None)
    return 0


def _normals(path: Path) -> Array:
    """Return view-space normals; pictures hold them as 0.5 + 0.5 n. Raises FormatError."""
    array = images.load_image(path)
    if array.dtype == np.uint8 and array.ndim == 3:
        array = array[..., :3].astype(np.float32) / 127.5 - 1
    return array
