"""``ssao-gl explain`` and ``ssao-gl methods``: what would be done, and what there is."""

from __future__ import annotations

import dataclasses
import json as json_module
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError, near_miss
from ..methods import registry
from ..passes.blur import BLURS
from ..pipeline import plan_render
from ..settings import limits
from ..tiles import layout
from .options import LookOptions, ViewOptions
from .output import say, table
from .tiling import TileOption


def explain(
    scene: Path | None = None,
    *,
    aov: Annotated[str, Parameter(help="What is wanted, by commas.")] = "image",
    tile: TileOption = None,
    json: Annotated[bool, Parameter(name="--json", negative="", help="As JSON.")] = False,
    view: ViewOptions = ViewOptions(),
    look: LookOptions = LookOptions(),
) -> int:
    """Print the plan of a render: passes, formats, sizes, slots, memory, and what was left out and why. Draws nothing.

    Parameters
    ----------
    scene
        Scene file. Without it: the embedded scene.
    """
    settings, size = look.settings(), view.pixels()
    loaded = view.load(scene)
    camera = view.choose(loaded)
    settings = settings.with_radius(camera.ao_radius or loaded.default_radius())
    aovs = tuple(part.strip() for part in aov.split(","))
    cut = layout(loaded, camera, size, settings, aovs, tile=tile)
    plan = plan_render(settings, cut.outer if cut else size, aovs)
    if json:
        content = {
            "scene": loaded.name, "triangles": loaded.triangles, "camera": camera.name, "settings": settings.table(),
            "passes": [
                {
                    "name": step.task.name, "reads": list(step.task.reads), "size": list(step.size),
                    "writes": [{"name": n, "format": plan.slots[s].format, "slot": s} for n, s in zip(step.writes, step.slots, strict=True)],
                }
                for step in plan.steps
            ],
            "slots": [{"format": s.format, "size": list(s.size), "bytes": s.bytes} for s in plan.slots],
            "bytes": plan.bytes, "left_out": dict(plan.culled), "tiles": cut.table() if cut else None,
        }  # fmt: skip
        say(json_module.dumps(content, indent=1))
        return 0
    method = settings.method
    say(f"{loaded.name}: {loaded.triangles:,} triangles in {len(loaded.draws)} meshes, camera {camera.name or 'automatic'}")
    say(f"{method.name}: " + ", ".join(f"{f.name} {getattr(method, f.name)}" for f in dataclasses.fields(method)))  # type: ignore[arg-type]
    if cut:
        say(f"{size[0]}x{size[1]} in {cut.describe()}; the plan of the largest:")
    say(plan.describe())
    return 0


def methods(name: str | None = None) -> int:
    """List the AO methods and filters with their settings, units and ranges.

    Parameters
    ----------
    name
        Only this one.
    """
    kinds = {**registry(), **{f"blur {key}": kind for key, kind in BLURS.items()}}
    if name is not None:
        chosen = {key: kind for key, kind in kinds.items() if name in (key, key.removeprefix("blur "))}
        if not chosen:
            raise SettingsError(f"unknown method or filter '{name}'; there are {', '.join(kinds)}.{near_miss(name, kinds)}")
        kinds = chosen
    for key, kind in kinds.items():
        say(f"{key}: {(kind.__doc__ or '').strip().splitlines()[0]}")
        rows = [
            (f.name, "auto" if f.default is None else str(f.default), limits(f).unit, limits(f).describe(), limits(f).doc)
            for f in dataclasses.fields(kind)
        ]
        table("", ("setting", "default", "unit", "range", "what it is"), rows)
        for contract, deviation in getattr(kind, "exceptions", {}).items():
            say(f"  by its definition it breaks '{contract}' (bound {deviation.bound:g}): {deviation.reason}")
    return 0
