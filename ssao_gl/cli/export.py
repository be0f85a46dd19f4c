"""``ssao-gl export``: the compiled pipeline, for runtimes other than this one."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError
from ..export.pipeline import PipelineInputs
from ..export.write import check_export, write_export
from .help_pages import OUTPUT
from .options import LookOptions
from .output import say
from .tokens import parse_share


def export(
    *,
    target: Annotated[
        str,
        Parameter(
            group=OUTPUT,
            help="webgl2 (an ES module and its runtime), three (with a pass of three.js), gles3 (shaders, a C header and a program) or json (and its schema).",
        ),
    ] = "webgl2",
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group=OUTPUT, help="Folder for the files.", allow_leading_hyphen=True)
    ] = Path("ssao-gl-export"),
    depth_kind: Annotated[
        str, Parameter(help="window (a depth buffer of any projection, 0..1) or eye (distance along the view axis).")
    ] = "window",
    normals: Annotated[
        bool, Parameter(help="View-space normals are given. [default: they are rebuilt from depth]", negative="")
    ] = False,
    color: Annotated[
        bool, Parameter(help="Colour is given, and dimmed. [default: the result is visibility]", negative="")
    ] = False,
    strength: Annotated[float, Parameter(help="With --color: 0 leaves it as it is, 1 dims it by all of the occlusion.")] = 1.0,
    look: LookOptions = LookOptions(),
) -> int:
    """Write the pipeline of apply: shaders, tables, formats and formulas, for canvases of every size and any projection."""
    check_export(output, target)
    settings = look.settings()
    if parse_share(look.radius or "") is not None and settings.method.traits.radius_unit == "scene units":
        raise SettingsError(f"--radius {look.radius}: an export knows no scene; give a length in the units of your depth")
    settings = dataclasses.replace(settings, shading=dataclasses.replace(settings.shading, ambient=strength))
    files = write_export(output, settings, PipelineInputs(depth_kind, normals, color), target)
    say(f"{output}: {', '.join(str(path.relative_to(output)) for path in files)}")
    return 0
