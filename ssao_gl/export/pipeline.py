"""The compiled pipeline of ``apply`` as one value that JSON can hold: what a runtime elsewhere needs, and nothing of Python's.

``pipeline.schema.json`` beside this file says what each part is.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import GraphError
from ..graph.draws import FloatTable, Fullscreen
from ..graph.names import COLOR, GIVEN_DEPTH, GIVEN_NORMAL, IMAGE, VISIBILITY
from ..graph.plan import Plan, PlannedPass
from ..io.json_values import to_json
from ..pipeline.build import WINDOW_DEPTH, plan_apply
from ..pipeline.settings import Settings
from ..scene.projection import Size
from .formulas import STANDARD, Formula, components, formula, number, scale_formulas
from .frames import LARGEST, SizedPlan, sized_plan, slot_scales
from .live import LiveSetting, LiveSettings, live_settings
from .shader_texts import COPY, VERTEX, ShaderTexts, shader_texts

FORMAT = "ssao_gl pipeline 1"
INPUTS: Mapping[str, str] = {GIVEN_DEPTH: "depth", GIVEN_NORMAL: "normals", COLOR: "color"}
"""Resource -> what a runtime's argument is called."""

Pipeline = dict[str, Any]
"""What ``pipeline.schema.json`` describes."""


@dataclass(frozen=True, slots=True)
class PipelineInputs:
    """What the pipeline is given. depth_kind: "window" or "eye". normals, color: whether there are."""

    depth_kind: str = WINDOW_DEPTH
    normals: bool = False
    color: bool = False

    @property
    def output(self) -> str:
        """The resource that it leaves."""
        return IMAGE if self.color else VISIBILITY

    def plan(self, settings: Settings, size: Size) -> Plan:
        """Return the plan that :class:`ssao_gl.Effect` runs, with all in it that can change later."""
        return plan_apply(settings, size, depth=self.depth_kind, normals=self.normals, outputs=(self.output,), live=True)


def pipeline(settings: Settings, given: PipelineInputs) -> Pipeline:
    """Return the pipeline of some settings, whose radius is settled. Raises SettingsError, GraphError."""
    made = sized_plan(lambda size: given.plan(settings, size))
    live = live_settings(settings, lambda other: given.plan(other, (LARGEST, LARGEST)))
    _check(made.plan)
    texts = shader_texts(made.plan)
    vertex, copy = texts.add(VERTEX, {}), texts.add(COPY, {})
    tables: dict[FloatTable, str] = {}
    steps = [_step(index, step, made, live, texts, tables) for index, step in enumerate(made.plan.steps)]
    output = next(step.task.writes[given.output] for step in made.plan.steps if given.output in step.writes)
    return {
        "format": FORMAT,
        "generator": f"ssao_gl {importlib.metadata.version('ssao_gl')}",
        "settings": to_json(settings.table()),
        "inputs": {
            INPUTS[name]: {"resource": name} | ({"kind": given.depth_kind} if name == GIVEN_DEPTH else {})
            for name in made.plan.inputs
        },
        "output": {"resource": given.output, "format": output.format},
        "cameras": sorted(settings.method.traits.cameras),
        "live": {name: _open(setting) for name, setting in live.open.items()},
        "fixed": dict(live.fixed),
        "largest": LARGEST,
        "slots": [
            {"format": slot.format, "scale": scale} for slot, scale in zip(made.plan.slots, slot_scales(made.plan), strict=True)
        ],
        "resources": dict(made.plan.where),
        "tables": {name: _table(table) for table, name in tables.items()},
        "vertex": vertex,
        "copy": copy,
        "standard": {name: value for name, value in STANDARD.items() if any(f" {name};" in t for t in texts.texts.values())},
        "steps": steps,
        "left_out": dict(made.plan.culled),
        "version_line": texts.version,
        "shaders": texts.texts,
    }


def _check(plan: Plan) -> None:
    """Raise GraphError for what the format cannot say."""
    for step in plan.steps:
        if not isinstance(step.task.draw, Fullscreen) or step.task.blend != "replace" or plan.history:
            raise GraphError(f"pass '{step.task.name}' cannot be exported: it is no plain pass over the screen")


def _step(
    index: int,
    step: PlannedPass,
    made: SizedPlan,
    live: LiveSettings,
    texts: ShaderTexts,
    tables: dict[FloatTable, str],
) -> dict[str, Any]:
    task, draw = step.task, step.task.draw
    assert isinstance(draw, Fullscreen)
    shader = texts.add(draw.shader, draw.defines)
    for table in draw.tables.values():
        tables.setdefault(table, f"table{len(tables)}")
    clear = task.clear if task.clear and task.test else None
    more = {
        "clear": None if clear is None else [None if name in task.over else list(clear) for name in step.writes],
        "depth": _depth(step),
        "when": list(made.when[task.name]) if task.name in made.when else None,
        "tables": {uniform: tables[table] for uniform, table in draw.tables.items()} or None,
    }
    return {
        "name": task.name,
        "role": task.role,
        "shader": shader,
        "defines": dict(draw.defines),
        "scale": step.scale,
        "writes": list(step.writes),
        "samplers": dict(draw.samplers),
        "uniforms": _uniforms(index, step, draw, live, texts.texts[shader] + texts.texts[VERTEX]),
    } | {key: value for key, value in more.items() if value is not None}


def _uniforms(index: int, step: PlannedPass, draw: Fullscreen, live: LiveSettings, declared: str) -> dict[str, Formula]:
    """Return the uniforms of a step, without those of ``standard``; its vertex shader's are among them."""
    own = {name: formula(value, live.parts(index, name)) for name, value in draw.uniforms.items()}
    return {name: value for name, value in scale_formulas(step).items() if f" {name};" in declared} | own


def _depth(step: PlannedPass) -> dict[str, Any] | None:
    """Return how a step uses its depth buffer: it writes it, or is tested against it."""
    if step.depth_slot is None:
        return None
    test = step.task.test
    rule = "always" if test is None else "gequal" if test.equal else "greater"
    return {"slot": step.depth_slot, "writes": step.task.depth is not None, "passes": rule}


def _open(setting: LiveSetting) -> dict[str, Any]:
    rule = setting.limits
    bounds = {"above": rule.above, "low": rule.low, "high": rule.high}
    return {"value": setting.value, "field": setting.field, "doc": rule.doc, "unit": rule.unit} | {
        key: bound for key, bound in bounds.items() if bound is not None
    }


def _table(table: FloatTable) -> dict[str, Any]:
    h, w, channels = table.shape
    return {"width": w, "height": h, "channels": channels, "data": [number(value) for value in components(table)]}
