"""``ssao-gl explain`` and ``ssao-gl methods``: what would be done, and what there is."""

from __future__ import annotations

import dataclasses
import json as json_module
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .. import planner
from ..errors import SettingsError
from ..experiment.culling_savings import FRAMES, benchmark_rules
from ..pipeline.build import plan_render
from ..pipeline.explain import plan_memory, rule_statuses
from ..pipeline.frame_setup import FrameSetup, frame_setup
from ..pipeline.outputs import aov_names
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..tiling.layout import USUAL_LIMIT, Layout, layout, unguarded
from .explain_text import Explained
from .options import GlOption, LitLookOptions, ViewOptions
from .output import say
from .plan_options import PlanOptions, drawn_at_once, listed, tell
from .tile_options import TileOption
from .tokens import WHOLE


def explain(
    scene: Path | None = None,
    *,
    aov: Annotated[str, Parameter(help="What is wanted, by commas.")] = "image",
    measure: Annotated[
        bool,
        Parameter(negative="", help="Draw the view with the rules of leaving out on and off: share shaded, time, difference."),
    ] = False,
    rounds: Annotated[int, WHOLE, Parameter(help="Interleaved rounds of --measure; medians are reported.")] = 5,
    tile: TileOption = None,
    gl: GlOption = "auto",
    json: Annotated[bool, Parameter(name="--json", negative="", help="As JSON.")] = False,
    view: ViewOptions = ViewOptions(),
    look: LitLookOptions = LitLookOptions(),
    goal: PlanOptions = PlanOptions(),
) -> int:
    """Print the plan of a render: passes, formats, sizes, slots, memory, and what was left out and why.

    Draws nothing without --measure, --budget-ms or --max-error; the last two also list everything that was considered.

    Parameters
    ----------
    scene
        Scene file. Without it: the embedded scene.
    """
    if rounds < 1:
        raise SettingsError(f"--rounds {rounds}: must be at least 1")
    settings, target, size = look.settings(), goal.target(look), view.pixels()
    loaded = view.load(scene)
    settings = look.settled(settings, loaded.default_radius)
    camera = view.choose(loaded)
    aovs = aov_names(aov)
    made, choice = frame_setup(loaded, camera, size, settings, USUAL_LIMIT), None
    if target:
        drawn_at_once(target, layout(loaded, camera, size, made.settings, aovs, tile=tile))
        with Renderer(gl) as renderer:
            choice = planner.plan(renderer, loaded, camera, size, target, settings, aovs=aovs)
        made = frame_setup(loaded, camera, size, choice.settings, USUAL_LIMIT)
    cut = layout(loaded, camera, size, made.settings, aovs, tile=tile)
    if cut and measure:
        raise SettingsError("--measure: a picture in tiles is not drawn at once; choose a smaller --size, and no --tile")
    look.dump(choice.settings if choice else settings)
    found = _explained(loaded, camera, size, made, cut, aovs)
    if measure:
        with Renderer(gl, keep=FRAMES) as renderer:
            measured = benchmark_rules(renderer, loaded, camera, size, made.settings, rounds=rounds)
            found = dataclasses.replace(found, savings=measured, where=f"{renderer.ctx.provider}, {renderer.ctx.renderer}")
    if json:
        say(json_module.dumps(found.table() | ({"planned": listed(choice)} if choice else {}), indent=1))
        return 0
    found.tell(rounds)
    if choice:
        tell(choice)
    return 0


def _explained(
    scene: Scene, camera: Camera, size: Size, made: FrameSetup, cut: Layout | None, aovs: tuple[str, ...]
) -> Explained:
    """Return what is to be said of a view, whole or in tiles, with nothing measured."""
    settings, outer = (unguarded(made.settings), cut.outer) if cut else (made.settings, made.outer)
    plan = plan_render(settings, outer, aovs, triangles=made.triangles)
    memory = plan_memory(settings, cut.outer if cut else size, plan)
    return Explained(scene, camera, made, plan, cut, memory, rule_statuses(made, plan), [], "")
