"""What ``ssao-gl explain`` tells of a plan: as lines, or as plain values for JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..experiment.culling_savings import COLUMNS, RuleBenchmark
from ..graph.names import FIELD
from ..graph.plan import Plan
from ..occupancy.field import BYTES
from ..occupancy.grid import grid_over
from ..pipeline.explain import PlanMemory, RuleStatus, resource_table
from ..pipeline.frame_setup import FrameSetup
from ..scene.camera import Camera
from ..scene.model import Scene
from ..tiling.layout import Layout
from ..truth.rays import tree_bytes
from .output import print_table, say

MIB = 2.0**20


@dataclass(frozen=True, slots=True)
class Explained:
    """A plan with its memory and its rules; ``savings`` are empty where nothing was measured, ``where`` says on what it was."""

    scene: Scene
    camera: Camera
    made: FrameSetup
    plan: Plan
    cut: Layout | None
    memory: PlanMemory
    rules: Sequence[RuleStatus]
    savings: Sequence[RuleBenchmark]
    where: str

    def table(self) -> dict[str, Any]:
        """As plain values."""
        plan, region = self.plan, self.made.region
        kept = [{**row, "kept": True} for row in resource_table(plan)]
        gone = [{"name": n, "kept": False, "reason": why, "bytes": plan.saved.get(n)} for n, why in plan.culled.items()]
        return {
            "scene": self.scene.name, "triangles": self.scene.triangles, "camera": self.camera.name, "settings": self.made.settings.table(),
            "passes": [
                {
                    "name": step.task.name, "reads": list(step.task.reads), "size": list(step.size),
                    "writes": [{"name": n, "format": plan.slots[s].format, "slot": s} for n, s in zip(step.writes, step.slots, strict=True)],
                    "where": step.task.test.name if step.task.test else None,
                }
                for step in plan.steps
            ],
            "slots": [{"format": s.format, "size": list(s.size), "bytes": s.bytes} for s in plan.slots],
            "bytes": plan.bytes,
            "left_out": dict(plan.culled),
            "resources": kept + gone,
            "rules": [{**dataclasses.asdict(rule), "in_force": not rule.why} for rule in self.rules],
            "memory": dataclasses.asdict(self.memory),
            "drawn": {"size": list(plan.frame), **({} if self.cut else {"inside": region.image_rect, "covered": region.scene_rect})},
            "measured": {"where": self.where, "rules": [dataclasses.asdict(one) for one in self.savings]} if self.where else None,
            "tiles": self.cut.table() if self.cut else None,
        }  # fmt: skip

    def tell(self, rounds: int) -> None:
        """Print it all."""
        scene, method = self.scene, self.made.settings.method
        say(
            f"{scene.name}: {scene.contents}{f' in {len(scene.meshes)} meshes' if scene.meshes else ''}, camera {self.camera.name or 'automatic'}"
        )
        if scene.spheres:
            say(_stored(scene))
        say(f"{method.name}: " + ", ".join(f"{f.name} {getattr(method, f.name)}" for f in dataclasses.fields(method)))  # type: ignore[arg-type]
        if FIELD in self.plan.inputs:
            say(_field(scene, method))
        if self.cut:
            w, h = self.cut.size
            say(f"{w}x{h} in {self.cut.describe()}; the plan of the largest:")
        say(self.plan.describe())
        for rule in self.rules:
            say(f"   {rule.describe()}")
        if not self.cut:
            for line in _drawn(self.made):
                say(f"   {line}")
        say(f"   {_memory(self.memory)}")
        if self.where and not self.savings:
            say("   measured: nothing, since no rule is in force")
        if self.savings:
            title = f"Rules on and off: {self.where}, all passes after the G-buffer, medians of {rounds} rounds"
            print_table(title, COLUMNS, [one.cells() for one in self.savings])


def _stored(scene: Scene) -> str:
    """Return how the spheres of a scene are kept, and what rays through all of them would take."""
    stored, copies = sum(len(one.centers) for one in scene.spheres), sum(len(one.transforms) for one in scene.spheres)
    size = sum(20 * len(one.centers) + 64 * len(one.transforms) for one in scene.spheres)
    told = f"spheres: {stored:,} in {copies:,} places, {size / MIB:.1f} MiB on the GPU"
    return f"{told}; rays would take about {tree_bytes(scene) / MIB:,.0f} MiB"


def _drawn(made: FrameSetup) -> list[str]:
    """Return what is drawn around the image, and what beside the scene is not."""
    lines = []
    (w, h), inside, covered = made.view.size, made.region.image_rect, made.region.scene_rect
    if inside:
        lines.append(
            f"guard: {inside[0] // made.region.pixel} pixels are drawn around the image, so that taps see what lies beside it"
        )
    if covered:
        share = covered[2] * covered[3] / (w * h)
        lines.append(f"footprint: the scene's box is seen in {share:.0%} of what is drawn; beside it nothing is shaded")
    return lines


def _memory(memory: PlanMemory) -> str:
    culled = ", ".join(f"{name} {size / MIB:.1f}" for name, size in memory.culled.items())
    parts = [
        f"memory: {memory.total / MIB:.1f} MiB, {memory.beyond / MIB:.1f} of it beyond G-buffer and outputs",
        f"saved: {memory.shared / MIB:.1f} by sharing slots, {sum(memory.culled.values()) / MIB:.1f} by leaving out ({culled or 'nothing'})",
    ]
    if memory.effect is not None:
        parts.append(f"an Effect takes {memory.effect / MIB:.1f} beyond the caller's depth, colour and picture")
    return "; ".join(parts)


def _field(scene: Scene, method: Any) -> str:
    """Say what is made of a scene for a method that looks into its voxels."""
    grid = grid_over(scene.bounds, method.side)
    size = " x ".join(map(str, grid.shape))
    taken = math.prod(grid.shape) * BYTES / MIB
    return f"made once: a field of {size} voxels of {grid.side:.4g}, {taken:.1f} MiB on the GPU; it serves every view"
