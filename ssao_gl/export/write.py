"""Exports as files: the pipeline, and beside it what runs it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from ..errors import SettingsError, near_miss
from ..io.atomic import atomic_write, check_writable, is_folder, locked_folder, make_folder
from ..pipeline.settings import Settings
from .native import native_files
from .pipeline import Pipeline, PipelineInputs, pipeline

HERE = Path(__file__).parent
SCHEMA = HERE / "pipeline.schema.json"
RUNTIME = HERE / "web" / "ssao-gl.js"

FOR_PEOPLE = ("generator", "settings", "left_out", "fixed")
"""Parts that no runtime needs."""

Files = Mapping[str, str]
"""Name in the folder, with slashes -> text."""


def json_files(made: Pipeline) -> Files:
    """Return the pipeline and the schema that describes it."""
    return {"pipeline.json": json.dumps(made, indent=1) + "\n", SCHEMA.name: SCHEMA.read_text("utf-8")}


def webgl2_files(made: Pipeline) -> Files:
    """Return a module with the pipeline, and the runtime with its types; both as small as they go without a tool."""
    head = "// ssao-gl export\n"
    return {
        "pipeline.js": f"{head}export default {json.dumps(slim(made), separators=(',', ':'))};\n",
        "pipeline.d.ts": 'import type { Pipeline } from "./ssao-gl.js";\ndeclare const pipeline: Pipeline;\nexport default pipeline;\n',
        RUNTIME.name: small_module(RUNTIME.read_text("utf-8")),
        "ssao-gl.d.ts": RUNTIME.with_suffix(".d.ts").read_text("utf-8"),
    }


def three_files(made: Pipeline) -> Files:
    """Return the same with a pass of three.js's EffectComposer."""
    three = RUNTIME.with_name("ssao-gl-three.js")
    more = {file.name: file.read_text("utf-8") for file in (three, three.with_suffix(".d.ts"))}
    return {**webgl2_files(made), **more}


def slim(made: Pipeline) -> Pipeline:
    """Return a pipeline without what is there for people."""
    live = {name: {k: v for k, v in one.items() if k not in ("doc", "unit", "field")} for name, one in made["live"].items()}
    steps = [{key: value for key, value in step.items() if key != "role"} for step in made["steps"]]
    return {key: value for key, value in made.items() if key not in FOR_PEOPLE} | {"live": live, "steps": steps}


def small_module(text: str) -> str:
    """Return a module of ours without comments and indentation; each of its statements ends in a semicolon."""
    first, *lines = (re.sub(r"(^| )// .*", "", line.strip()) for line in text.splitlines())
    code = "\n".join(line for line in (first, *lines) if line)
    return "// ssao_gl, MIT licence\n" + re.sub(r"([;{,(\[])\n", r"\1", code) + "\n"


TARGETS: Mapping[str, Callable[[Pipeline], Files]] = {
    "webgl2": webgl2_files,
    "three": three_files,
    "gles3": native_files,
    "json": json_files,
}
"""Name of a target -> the files that it gets."""


def check_export(output: Path, target: str) -> None:
    """Raise SettingsError or FormatError, before any work is done, for an unknown target or a place that is no folder."""
    if target not in TARGETS:
        raise SettingsError(f"target '{target}': must be one of {', '.join(TARGETS)}.{near_miss(target, TARGETS)}")
    check_writable(output, folder=True)


def write_export(output: Path, settings: Settings, given: PipelineInputs, target: str) -> list[Path]:
    """Write an export into a folder, which is made; return the files. Raises SettingsError, FormatError, GraphError."""
    check_export(output, target)
    if settings.method.radius is None:
        raise SettingsError(f"export: give {settings.method.name} a radius, in the units of your depth; it can change later")
    files = TARGETS[target](pipeline(settings, given))
    make_folder(output)
    with locked_folder(output):
        for name, text in files.items():
            path = output / name
            if not is_folder(path.parent):
                make_folder(path.parent)
            with atomic_write(path) as temporary:
                temporary.write_text(text, "utf-8")
    return [output / name for name in files]
