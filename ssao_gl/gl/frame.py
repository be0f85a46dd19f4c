"""Runs a compiled plan: owns its textures and framebuffers, draws its steps, times them."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import ContextError
from ..graph import Plan, Step
from ..sources import Define
from ..view import View
from .context import Context
from .kit import FORMATS, Kit


class Target(Protocol):
    """What a pass draws into: a framebuffer of the frame, or one of the caller's."""

    def use(self) -> None: ...


@dataclass(slots=True)
class Stage:
    """What a pass sees when it draws."""

    kit: Kit
    step: Step
    target: Target
    textures: dict[str, moderngl.Texture]
    view: View
    context: Any = None
    """What the caller of :meth:`Frame.run` passed along (the scene, say)."""

    def fullscreen(
        self,
        fragment: str,
        uniforms: Mapping[str, Any],
        samplers: Mapping[str, str],
        *,
        defines: Mapping[str, Define] | None = None,
        lookups: Mapping[str, NDArray[np.float32]] | None = None,
    ) -> None:
        """Draw one triangle with the shader ``fragment``.

        ``samplers`` maps sampler uniforms to resource names, ``lookups`` to small repeating arrays; the constants of the
        view are set where the shader declares them.
        """
        every = dict(defines or {})
        if self.view.pinhole:
            every["PINHOLE"] = 1
        program, vao = self.kit.triangle(fragment, every)
        unit = 0
        units = {}
        for name, resource in samplers.items():
            self.kit.bind(unit, self.textures[resource])
            units[name] = unit
            unit += 1
        for name, values in (lookups or {}).items():
            self.kit.bind(unit, self.kit.lookup(values), repeat=True)
            units[name] = unit
            unit += 1
        program.set(units)
        program.set({k: v for k, v in self.view.constants.items() if k in program.declared})
        program.set(uniforms)
        self.target.use()
        vao.render(moderngl.TRIANGLES)


@dataclass(frozen=True, slots=True)
class PassTime:
    """Milliseconds that a pass took, and by which clock."""

    name: str
    ms: float
    clock: str
    cpu_ms: float
    """Of all threads of this process: on a software renderer the work itself, whatever else the machine does."""


class Frame:
    """The GL side of a plan. Raises ContextError when the driver cannot make its textures."""

    def __init__(self, kit: Kit, plan: Plan) -> None:
        self.kit, self.plan = kit, plan
        ctx = kit.ctx
        limit = ctx.max_size
        if max(plan.frame) > limit:
            raise ContextError(f"a frame of {plan.frame[0]}x{plan.frame[1]}: {ctx.renderer} draws at most {limit} a side")
        self._owned: list[Any] = []
        try:
            self._slots = [self._make(slot.format, slot.size) for slot in plan.slots]
            self._targets = [self._framebuffer(step) for step in plan.steps]
        except moderngl.Error as error:
            self.release()
            raise ContextError(f"{ctx.renderer} cannot make the targets of {plan.frame[0]}x{plan.frame[1]}: {error}") from None
        self._textures = {name: self._slots[slot] for name, slot in plan.where.items()}
        self.times: list[PassTime] = []
        self._timer: Timer | None = None

    def _make(self, format_: str, size: tuple[int, int]) -> Any:
        mgl = self.kit.ctx.mgl
        if format_ == "depth24":
            made: Any = mgl.depth_renderbuffer(size)
        else:
            components, dtype = FORMATS[format_]
            made = mgl.texture(size, components, dtype=dtype)
            made.filter = (moderngl.NEAREST, moderngl.NEAREST)
            made.repeat_x = made.repeat_y = False
        self._owned.append(made)
        return made

    def _framebuffer(self, step: Step) -> moderngl.Framebuffer:
        depth = None if step.depth_slot is None else self._slots[step.depth_slot]
        made = self.kit.ctx.mgl.framebuffer([self._slots[slot] for slot in step.slots], depth)
        self._owned.append(made)
        return made

    def run(
        self,
        view: View,
        inputs: Mapping[str, moderngl.Texture] | None = None,
        *,
        context: Any = None,
        targets: Mapping[str, Target] | None = None,
        timed: bool = False,
        checked: bool = False,
    ) -> dict[str, moderngl.Texture]:
        """Draw every step and return the output textures by name.

        ``targets`` draws an output once more, into a framebuffer of the caller's. ``timed`` fills ``times``; ``checked``
        asks OpenGL for errors after each pass and raises ContextError naming it.
        """
        textures = {**self._textures, **(inputs or {})}
        stage = Stage(self.kit, self.plan.steps[0], self._targets[0], textures, view, context)
        timer = None
        if timed:
            timer = self._timer = self._timer or Timer(self.kit.ctx)
            timer.restart()
        for step, target in zip(self.plan.steps, self._targets, strict=True):
            stage.step, stage.target = step, target
            if timer:
                timer.start()
            step.task.draw(stage)
            if targets and len(step.writes) == 1 and step.writes[0] in targets:
                stage.target = targets[step.writes[0]]
                step.task.draw(stage)
            if timer:
                timer.stop(step.task.name)
            if checked:
                self.kit.ctx.check_error(f"pass '{step.task.name}'")
        if timer:
            self.times = timer.results()
        return {name: textures[name] for name in self.plan.outputs}

    def read(self, name: str) -> NDArray[Any]:
        """A resource of the plan as an array (h, w, channels), row 0 at the *bottom*: float32, or uint8 for 8-bit formats."""
        index = next(i for i, step in enumerate(self.plan.steps) if name in step.writes)
        step = self.plan.steps[index]
        attachment = step.writes.index(name)
        components, dtype = FORMATS[step.task.writes[name].format]
        wide = "f1" if dtype == "f1" else "f4"
        # Four channels whatever the format: the only reading that OpenGL ES promises.
        data = self._targets[index].read(components=4, attachment=attachment, dtype=wide)
        array = np.frombuffer(data, np.uint8 if wide == "f1" else np.float32)
        w, h = step.size
        return array.reshape(h, w, 4)[..., :components]

    def release(self) -> None:
        """Free every texture and framebuffer. Calling it twice does no harm."""
        if self._owned:
            self.kit.home.use()
        for made in reversed(self._owned):
            made.release()
        self._owned = []


class Timer:
    """Times passes: by GL's own timer on a GPU that has one, else by waiting for each pass with the wall clock."""

    def __init__(self, ctx: Context) -> None:
        self._ctx = ctx
        self._gpu = ctx.gpu_timer
        self.clock = "gpu" if self._gpu else "wall"
        self._queries: list[Any] = []  # used again: moderngl never frees one
        self._names: list[str] = []
        self._waits: list[float] = []
        self._cpu: list[float] = []
        self._began = self._cpu_began = 0.0

    def restart(self) -> None:
        """Forget what was timed."""
        self._names, self._waits, self._cpu = [], [], []
        if not self._gpu:
            self._ctx.mgl.finish()

    def start(self) -> None:
        if self._gpu:
            if len(self._names) == len(self._queries):
                self._queries.append(self._ctx.mgl.query(time=True))
            self._queries[len(self._names)].mglo.begin()
        self._began, self._cpu_began = time.perf_counter(), time.process_time()

    def stop(self, name: str) -> None:
        if self._gpu:
            self._queries[len(self._names)].mglo.end()
        else:
            self._ctx.mgl.finish()
            self._waits.append(1e3 * (time.perf_counter() - self._began))
        self._names.append(name)
        self._cpu.append(1e3 * (time.process_time() - self._cpu_began))

    def results(self) -> list[PassTime]:
        spent = [query.elapsed * 1e-6 for query in self._queries[: len(self._names)]] if self._gpu else self._waits
        return [PassTime(name, ms, self.clock, cpu) for name, ms, cpu in zip(self._names, spent, self._cpu, strict=True)]
