"""What is left out of a view, by which rules and why, and the memory that saves. See :data:`.settings.CULLING_RULES`.

``ssao_gl.experiment.culling_savings`` measures what the rules save in time, and what they change.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError
from ..graph.declare import BYTES, DEPTH_FORMAT
from ..graph.names import IMAGE
from ..graph.plan import Plan
from ..scene.projection import Size
from .build import plan_apply
from .frame_setup import FrameSetup
from .settings import CULLING_RULES, Settings


@dataclass(frozen=True, slots=True)
class RuleStatus:
    """A rule of leaving out in one view. ``why``: the reason why it is not in force; empty where it is."""

    name: str
    what: str
    why: str
    exact: bool
    """Whether the picture stays as it is to the last bit: the bound on the error is 0. Else the error is only measured."""

    def describe(self) -> str:
        """In one line."""
        state = f"not in force: {self.why}" if self.why else f"in force, {'exact' if self.exact else 'error measured only'}"
        return f"rule {self.name}: {self.what}; {state}"


@dataclass(frozen=True, slots=True)
class PlanMemory:
    """Bytes of a plan's textures. ``beyond`` is what is neither G-buffer nor output."""

    total: int
    shared: int
    """Saved because textures serve several resources in turn."""
    culled: Mapping[str, int]
    """Saved by each pass or resource that nobody wants."""
    beyond: int
    effect: int | None
    """What :class:`ssao_gl.Effect` takes for images of the same size beyond the caller's depth, colour and the picture;
    None for methods that need a scene."""


def rule_statuses(made: FrameSetup, plan: Plan) -> list[RuleStatus]:
    """Every rule, in force or not and why, in a view that ``plan`` draws."""
    method, keep = made.settings.method, made.settings.keep
    traits = method.traits
    adaptive = traits.probe is not None and "adaptive" not in keep
    asked = (
        f"it is asked for with {method.name}.{traits.probe_setting}=true" if traits.probe_setting else f"{method.name} cannot"
    )
    why = {
        "background": "",
        "open": "the adaptive rule looks for blocks" if adaptive else plan.culled.get("open blocks", ""),
        "adaptive": "" if adaptive else asked,
    }
    if not any(step.task.role == "occlusion" for step in plan.steps):
        why = dict.fromkeys(CULLING_RULES, "no occlusion is drawn")
    why |= dict.fromkeys(keep, "switched off")
    return [RuleStatus(name, what, why[name], exact=name != "adaptive") for name, what in CULLING_RULES.items()]


def plan_memory(settings: Settings, size: Size, plan: Plan) -> PlanMemory:
    """Return what ``plan`` takes and saves. ``size``: of the image, without what is drawn around it."""
    own = {plan.where[name] for name in plan.outputs}
    for step in plan.steps:
        if step.task.role == "gbuffer":
            own |= {*step.slots, *([] if step.depth_slot is None else [step.depth_slot])}
    beyond = sum(slot.bytes for index, slot in enumerate(plan.slots) if index not in own)
    try:
        effect = plan_apply(settings, size, outputs=(IMAGE,)).bytes - BYTES["rgba8"] * size[0] * size[1]
    except SettingsError:
        effect = None
    return PlanMemory(plan.bytes, plan.unaliased_bytes - plan.bytes, plan.saved, beyond, effect)


def resource_table(plan: Plan) -> list[dict[str, Any]]:
    """All resources that the plan writes, as plain values: by which pass, format, size, bytes, slot."""
    found = []
    for step in plan.steps:
        targets = [(name, plan.slots[slot].format, slot) for name, slot in zip(step.writes, step.slots, strict=True)]
        targets += [(step.task.depth, DEPTH_FORMAT, step.depth_slot)] if step.task.depth and step.depth_slot is not None else []
        for name, format_, slot in targets:
            taken = plan.slots[slot].bytes
            row = {
                "name": name,
                "pass": step.task.name,
                "format": format_,
                "size": list(step.size),
                "bytes": taken,
                "slot": slot,
            }
            found.append(row)
    return found
