"""Interprets the draws of a compiled plan: the only code that turns records of ``graph/draws.py`` into OpenGL calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import ContextError
from ..graph.draws import DrawElements, DrawScene, Fullscreen, HostWork, ViewValue
from ..graph.names import DEPTH, DEPTH_LAYER_2
from ..graph.plan import Plan, PlannedPass
from ..graph.regions import DrawRegion, Rect
from ..scene.camera import Camera
from ..scene.lamps import LitView
from ..scene.projection import ViewConstants
from .clearing import DrawTarget, clear_targets
from .draw_state import DrawState
from .field_textures import FieldTextures
from .frame_targets import FrameTargets
from .programs import FORMATS, GpuResources, Program
from .scene_buffers import SceneBuffers
from .timer import PassTime, Timer
from .view_values import onto_target, target_constants, view_value

WHOLE = DrawRegion()


HostFunction = Callable[[HostWork, ViewConstants, Rect, Sequence[NDArray[Any]]], NDArray[np.float32]]
"""Does the work of a plan that is the host's: called with the part of the frame and the resources of it that it reads, row 0 at
the bottom, it returns (h, w)."""


@dataclass(frozen=True, slots=True, eq=False)
class SceneView:
    """What a plan with a G-buffer draws: a scene on the GPU, and the camera that looks at it.

    hosts: who does what the host computes of it, by the name of the work. lit: what follows from where the camera and the
    lights stand. field: its occupancy, where a pass reads it.
    """

    buffers: SceneBuffers
    camera: Camera
    hosts: Mapping[str, HostFunction] = field(default_factory=dict)
    lit: LitView = field(default_factory=LitView)
    field: FieldTextures | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Bound:
    """A full-screen draw with its program, for one kind of projection."""

    program: Program
    triangle: moderngl.VertexArray
    tables: Sequence[moderngl.Texture]
    units: Mapping[str, int]


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFrame:
    """A frame as it was drawn; valid until the next one. ``outputs``: the plan's, by name."""

    plan: Plan
    outputs: Mapping[str, moderngl.Texture]
    times: Sequence[PassTime]
    """Milliseconds of each pass, where they were asked for."""
    _framebuffers: Sequence[moderngl.Framebuffer]
    _region: DrawRegion

    def read_all(self, name: str) -> NDArray[Any]:
        """Return the same, with what is drawn around the part that was wanted."""
        return _read(self.plan, self._framebuffers, name, WHOLE)

    def read(self, name: str) -> NDArray[Any]:
        """Return a resource as an array (h, w, channels), row 0 at the *bottom*: float32, or uint8 or uint32 for integer formats.

        Of resources of full size the part that was wanted.
        """
        return _read(self.plan, self._framebuffers, name, self._region)


def _read(plan: Plan, framebuffers: Sequence[moderngl.Framebuffer], name: str, region: DrawRegion) -> NDArray[Any]:
    """Return a resource as :meth:`DrawnFrame.read` does."""
    index = next(i for i, step in enumerate(plan.steps) if name in step.writes)
    step = plan.steps[index]
    components, dtype = FORMATS[step.task.writes[name].format]
    kind = {"f1": "f1", "u4": "u4"}.get(dtype, "f4")
    rect = region.wanted_of(step)
    # Four channels whatever the format: the only reading that OpenGL ES promises.
    attachment = step.writes.index(name)
    data = framebuffers[index].read(viewport=rect, components=4, attachment=attachment, dtype=kind)
    array = np.frombuffer(data, {"f1": np.uint8, "u4": np.uint32, "f4": np.float32}[kind])
    return array.reshape(rect[3], rect[2], 4)[..., :components]


class FrameExecutor:
    """Draws a plan into targets of its layout, again and again."""

    def __init__(self, resources: GpuResources, plan: Plan, targets: FrameTargets | None = None) -> None:
        """``targets``: those of another plan of the same layout, to be shared; its owner releases them."""
        self.plan, self.targets = plan, targets or FrameTargets(resources, plan.layout)
        self._resources = resources
        self._state = DrawState(resources.ctx)
        self._bound: dict[tuple[int, bool], _Bound] = {}
        self._timer: Timer | None = None
        self._moment: Mapping[str, Any] = {}

    def run(
        self,
        view: ViewConstants,
        inputs: Mapping[str, Any] | None = None,
        *,
        scene: SceneView | None = None,
        region: DrawRegion = WHOLE,
        copies: Mapping[str, DrawTarget] | None = None,
        moment: Mapping[str, Any] | None = None,
        timed: bool = False,
        checked: bool = False,
    ) -> DrawnFrame:
        """Draw every step.

        inputs: the caller's textures by name. region: which part is drawn. copies: outputs to draw into framebuffers of the
        caller's as well. moment: uniforms of this frame alone, for the shaders that declare them. ``timed`` measures each pass; ``checked`` asks OpenGL for errors after each pass and raises
        ContextError naming it.
        """
        slots, framebuffers = self.targets.slots, self.targets.framebuffers
        textures = {name: slots[slot] for name, slot in self.plan.where.items()} | dict(inputs or {})
        textures |= scene.field.textures if scene and scene.field else {}
        timer = self._restarted() if timed else None
        self._moment = moment or {}
        for index, step in enumerate(self.plan.steps):
            if timer:
                timer.start(host=isinstance(step.task.draw, HostWork))
            self._draw(index, step, framebuffers[index], textures, view, scene, region)
            if timer:
                timer.stop(step.task.name, step.task.role)
            if checked:
                self._resources.ctx.check_error(f"pass '{step.task.name}'")
        for name, target in (copies or {}).items():
            self._copy(textures[name], target)
        self.targets.frames += 1
        outputs = {name: textures[name] for name in self.plan.outputs}
        return DrawnFrame(self.plan, outputs, timer.results() if timer else (), framebuffers, region)

    def _restarted(self) -> Timer:
        self._timer = self._timer or Timer(self._resources.ctx)
        self._timer.restart()
        return self._timer

    def _draw(
        self,
        index: int,
        step: PlannedPass,
        target: DrawTarget,
        textures: Mapping[str, Any],
        view: ViewConstants,
        scene: SceneView | None,
        region: DrawRegion,
    ) -> None:
        match step.task.draw:
            case Fullscreen() as draw:
                if step.task.clear and (step.task.test or not region.whole):
                    clear_targets(self._resources.ctx, step, target, dict.fromkeys(step.writes, step.task.clear))
                self._fullscreen(index, draw, step, target, textures, view, region, scene)
            case DrawScene() as draw:
                if scene is None:
                    raise ContextError(f"pass '{step.task.name}' draws a scene, and this frame has none")
                clear_targets(self._resources.ctx, step, target, draw.clears)
                self._scene(draw, step, textures, view, scene)
            case DrawElements() as draw:
                clear_targets(self._resources.ctx, step, target, dict.fromkeys(step.writes, (0.0,) * 4))
                self._elements(draw, step, textures, view, scene, region)
            case HostWork() as draw:
                if scene is None or draw.work not in scene.hosts:
                    raise ContextError(f"pass '{step.task.name}' is the host's work, and nobody does it in this frame")
                clear_targets(self._resources.ctx, step, target, dict.fromkeys(step.writes, step.task.clear or (0.0,) * 4))
                self._host(draw, step, textures, view, scene.hosts[draw.work], region)

    def _fullscreen(
        self,
        index: int,
        draw: Fullscreen,
        step: PlannedPass,
        target: DrawTarget,
        textures: Mapping[str, Any],
        view: ViewConstants,
        region: DrawRegion,
        scene: SceneView | None,
    ) -> None:
        bound = self._bound.get((index, view.pinhole)) or self._bind(index, draw, view.pinhole)
        resources = self._resources
        for unit, resource in enumerate(draw.samplers.values()):
            resources.bind(unit, textures[resource])
        for unit, table in enumerate(bound.tables, len(draw.samplers)):
            resources.bind(unit, table, repeat=True)
        # Another pass, or another view, has set the program's uniforms to its own values.
        if bound.program.user != (bound, view):
            self._set_uniforms(bound, draw, step, textures, view)
            bound.program.user = (bound, view)
        bound.program.set(self._placed(draw, bound.program, scene))
        target.use()
        with self._state(step, region.of(step)):
            bound.triangle.render(moderngl.TRIANGLES)

    def _placed(self, draw: Fullscreen, program: Program, scene: SceneView | None) -> dict[str, Any]:
        """Return the uniforms that are another frame's or camera's though the view be the same: moment, light, field."""
        lit = {name: scene.lit.values[name] for name in draw.lit} if scene else {}
        field_ = scene.field.uniforms(scene.camera) if scene and scene.field else {}
        own = {**self._moment, **field_}
        return lit | {name: value for name, value in own.items() if name in program.declared}

    def _bind(self, index: int, draw: Fullscreen, pinhole: bool) -> _Bound:
        defines = {**draw.defines, **({"PINHOLE": 1} if pinhole else {})}
        program, triangle = self._resources.triangle(draw.shader, defines)
        units = {name: unit for unit, name in enumerate([*draw.samplers, *draw.tables])}
        tables = [self._resources.table(values) for values in draw.tables.values()]
        bound = self._bound[index, pinhole] = _Bound(program, triangle, tables, units)
        return bound

    def _set_uniforms(
        self, bound: _Bound, draw: Fullscreen, step: PlannedPass, textures: Mapping[str, Any], view: ViewConstants
    ) -> None:
        program = bound.program
        standard = {**view.constants, **target_constants(view, step)}
        program.set(bound.units)
        program.set({name: value for name, value in standard.items() if name in program.declared})
        program.set(self._evaluated(draw, step, textures, view))

    def _evaluated(
        self, draw: Fullscreen | DrawScene | DrawElements, step: PlannedPass, textures: Mapping[str, Any], view: ViewConstants
    ) -> dict[str, Any]:
        """Return the uniforms of a draw, with what depends on the view put in."""
        return {
            name: view_value(value, view, step, lambda resource: textures[resource].size)
            if isinstance(value, ViewValue)
            else value
            for name, value in draw.uniforms.items()
        }

    def _scene(
        self, draw: DrawScene, step: PlannedPass, textures: Mapping[str, Any], view: ViewConstants, scene: SceneView
    ) -> None:
        units = self._units(draw, textures)
        uniforms = {**units, **self._evaluated(draw, step, textures, view)}
        depths = [name for name in step.writes if name in (DEPTH, DEPTH_LAYER_2)]
        framebuffers = self.targets.framebuffers
        drawn = (lambda: _read(self.plan, framebuffers, depths[0], WHOLE)[..., 0]) if depths else None
        with self._state.nearest_surface():
            if draw.view == "camera":
                scene.buffers.draw(draw, scene.camera, view, step.writes, uniforms, onto_target(view, step), drawn)
            else:
                scene.buffers.draw(draw, *scene.lit.eyes[draw.view], step.writes, uniforms, np.eye(4), drawn)

    def _units(self, draw: DrawScene | DrawElements, textures: Mapping[str, Any]) -> dict[str, int]:
        """Bind the resources that a draw samples, and return the unit of each sampler."""
        for unit, resource in enumerate(draw.samplers.values()):
            self._resources.bind(unit, textures[resource])
        return {name: unit for unit, name in enumerate(draw.samplers)}

    def _elements(
        self,
        draw: DrawElements,
        step: PlannedPass,
        textures: Mapping[str, Any],
        view: ViewConstants,
        scene: SceneView | None,
        region: DrawRegion,
    ) -> None:
        if scene is None:
            raise ContextError(f"pass '{step.task.name}' draws a scene, and there is none")
        if any(step.task.writes[name].format == "r32f" for name in step.writes) and not self._resources.ctx.blends_floats:
            raise ContextError(
                f"pass '{step.task.name}': {self._resources.ctx.renderer} does not add up 32-bit floats; use half floats"
                " (the method's sums=half), or another method"
            )
        units = self._units(draw, textures)
        standard = {**view.constants, **target_constants(view, step)}
        uniforms = {**standard, **units, **self._evaluated(draw, step, textures, view)}
        with self._state(step, region.of(step)):
            scene.buffers.draw_elements(draw, scene.camera, view, uniforms, onto_target(view, step))

    def _host(
        self,
        draw: HostWork,
        step: PlannedPass,
        textures: Mapping[str, Any],
        view: ViewConstants,
        work: HostFunction,
        region: DrawRegion,
    ) -> None:
        """Read back what the work asks for, and write its result where the image is wanted."""
        rect = region.image_rect or (0, 0, *step.size)
        read = [_read(self.plan, self.targets.framebuffers, name, region) for name in draw.samplers.values()]
        found = np.ascontiguousarray(work(draw, view, rect, read), np.float32)
        textures[step.writes[0]].write(found.tobytes(), viewport=rect)

    def _copy(self, texture: moderngl.Texture, target: DrawTarget) -> None:
        """Draw an output into a framebuffer of the caller's."""
        program, triangle = self._resources.triangle("copy.frag", {})
        self._resources.bind(0, texture)
        program.set({"u_image": 0, "u_texel": (1 / texture.width, 1 / texture.height)})
        target.use()
        triangle.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free the targets. Calling it twice does no harm."""
        self.targets.release()
