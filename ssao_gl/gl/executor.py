"""Runs a compiled plan: owns its textures and framebuffers, draws its steps."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import ContextError
from ..glsl.preprocess import Define
from ..graph.declare import DEPTH
from ..graph.plan import Plan, PlannedPass
from ..graph.regions import Rect, drawn_rect
from ..scene.projection import ViewConstants
from .context import Context
from .programs import FORMATS, GpuResources
from .timer import PassTime, Timer

GL_COLOR, GL_DEPTH, GL_DEPTH_TEST, GL_SCISSOR_TEST = 0x1800, 0x1801, 0x0B71, 0x0C11
GL_LESS, GL_GREATER, GL_GEQUAL, GL_ALWAYS = 0x0201, 0x0204, 0x0206, 0x0207


class DrawTarget(Protocol):
    """What a pass draws into: a framebuffer of the frame, or one of the caller's."""

    def use(self) -> None: ...


@dataclass(slots=True)
class Stage:
    """What a pass sees when it draws."""

    kit: GpuResources
    step: PlannedPass
    target: DrawTarget
    textures: dict[str, moderngl.Texture]
    view: ViewConstants
    tester: Tester
    context: Any = None
    """What the caller of :meth:`FrameExecutor.run` passed along (the scene, say)."""
    defines: Mapping[str, Define] = field(default_factory=dict)
    """For all its shaders."""

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
        view and of the target are set where the shader declares them. Only pixels that the pass's test lets are drawn.
        """
        every = {**self.defines, **(defines or {})}
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
        program.set({k: v for k, v in target_constants(self.step, self.view).items() if k in program.declared})
        program.set(uniforms)
        self.target.use()
        with self.tester(self.step):
            vao.render(moderngl.TRIANGLES)

    def copy(self, resource: str, target: DrawTarget) -> None:
        """Draw a resource into a framebuffer of the caller's."""
        program, vao = self.kit.triangle("copy.frag", {})
        self.kit.bind(0, self.textures[resource])
        program.set({"u_image": 0, "u_texel": self.view.constants["u_texel"]})
        target.use()
        vao.render(moderngl.TRIANGLES)


def target_constants(step: PlannedPass, view: ViewConstants) -> dict[str, Any]:
    """Uniforms of ``lib/pixel.glsl``. A fragment of a smaller target stands for ``scale`` by ``scale`` pixels of the image."""
    (w, h), scale = view.size, step.scale
    return {
        "u_target_texel": (1 / step.size[0], 1 / step.size[1]),
        "u_target_uv": (scale / w, scale / h),
        "u_scale": float(scale),
        "u_test_depth": 1.0 if step.task.test and step.task.test.far else 0.0,
    }


class Tester:
    """``with tester(task):`` full-screen draws go through the pass's depth test, or write its depth buffer; passes that say
    what is left elsewhere (``clear``) draw only where ``inside`` and ``covered`` meet, in pixels of the image."""

    def __init__(self, ctx: Context) -> None:
        gl = ctx.functions
        self._enable, self._disable = gl("glEnable", None, ctypes.c_uint), gl("glDisable", None, ctypes.c_uint)
        self._func = gl("glDepthFunc", None, ctypes.c_uint)
        self._scissor = gl("glScissor", None, *[ctypes.c_int] * 4)
        self.inside: Rect | None = None
        self.covered: Rect | None = None
        self._depth = self._cut = False

    def __call__(self, step: PlannedPass) -> Tester:
        task = step.task
        rect = drawn_rect(step, self.inside, self.covered)
        self._depth, self._cut = bool(task.test or task.depth), rect is not None
        if self._depth:
            self._enable(GL_DEPTH_TEST)
            self._func((GL_GEQUAL if task.test.equal else GL_GREATER) if task.test else GL_ALWAYS)
        if rect:
            self._enable(GL_SCISSOR_TEST)
            self._scissor(*rect)
        return self

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        if self._depth:
            self._disable(GL_DEPTH_TEST)
            self._func(GL_LESS)
        if self._cut:
            self._disable(GL_SCISSOR_TEST)


class FrameExecutor:
    """The GL side of a plan. Raises ContextError when the driver cannot make its textures."""

    def __init__(self, kit: GpuResources, plan: Plan) -> None:
        self.kit, self.plan = kit, plan
        ctx = kit.ctx
        limit = ctx.max_size
        if max(plan.frame) > limit:
            raise ContextError(f"a frame of {plan.frame[0]}x{plan.frame[1]}: {ctx.renderer} draws at most {limit} a side")
        self._owned: list[Any] = []
        try:
            self._slots = [self._make(slot.format, slot.size) for slot in plan.slots]
            self._targets = [self._framebuffer(step) for step in plan.steps]
        except BaseException as error:
            self.release()
            if not isinstance(error, moderngl.Error):
                raise
            raise ContextError(f"{ctx.renderer} cannot make the targets of {plan.frame[0]}x{plan.frame[1]}: {error}") from None
        self._textures = {name: self._slots[slot] for name, slot in plan.where.items()}
        self._tester = Tester(ctx)
        self.times: list[PassTime] = []
        self._timer: Timer | None = None

    def _make(self, format_: str, size: tuple[int, int]) -> Any:
        mgl = self.kit.ctx.mgl
        if format_ == DEPTH:
            made: Any = mgl.depth_renderbuffer(size)
        else:
            components, dtype = FORMATS[format_]
            made = mgl.texture(size, components, dtype=dtype)
            made.filter = (moderngl.NEAREST, moderngl.NEAREST)
            made.repeat_x = made.repeat_y = False
        self._owned.append(made)
        return made

    def _framebuffer(self, step: PlannedPass) -> moderngl.Framebuffer:
        depth = None if step.depth_slot is None else self._slots[step.depth_slot]
        made = self.kit.ctx.mgl.framebuffer([self._slots[slot] for slot in step.slots], depth)
        made.depth_mask = step.task.depth is not None
        self._owned.append(made)
        return made

    def _clear(self, step: PlannedPass, target: DrawTarget) -> None:
        """What a pass leaves where it does not draw."""
        target.use()
        clear = self.kit.ctx.functions("glClearBufferfv", None, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
        for index, name in enumerate(step.writes):
            if name not in step.task.over:
                clear(GL_COLOR, index, ctypes.addressof((ctypes.c_float * 4)(*(step.task.clear or (0.0,) * 4))))
        if step.task.depth:
            clear(GL_DEPTH, 0, ctypes.addressof(ctypes.c_float(1.0)))

    def run(
        self,
        view: ViewConstants,
        inputs: Mapping[str, moderngl.Texture] | None = None,
        *,
        context: Any = None,
        inside: Rect | None = None,
        covered: Rect | None = None,
        targets: Mapping[str, DrawTarget] | None = None,
        timed: bool = False,
        checked: bool = False,
    ) -> dict[str, moderngl.Texture]:
        """Draw every step and return the output textures by name.

        ``inside``: the part of the image that is wanted; what only it needs is drawn only there, and :meth:`read` gives it.
        ``covered``: the part beside which there is nothing but background.
        ``targets`` copies an output into a framebuffer of the caller's. ``timed`` fills ``times``; ``checked``
        asks OpenGL for errors after each pass and raises ContextError naming it.
        """
        textures = {**self._textures, **(inputs or {})}
        self._tester.inside, self._tester.covered = inside, covered
        stage = Stage(self.kit, self.plan.steps[0], self._targets[0], textures, view, self._tester, context)
        timer = None
        if timed:
            timer = self._timer = self._timer or Timer(self.kit.ctx)
            timer.restart()
        for step, target in zip(self.plan.steps, self._targets, strict=True):
            stage.step, stage.target = step, target
            if timer:
                timer.start()
            if step.task.clear and (step.task.test or inside or covered):
                self._clear(step, target)
            step.task.draw(stage)
            if timer:
                timer.stop(step.task.name)
            if checked:
                self.kit.ctx.check_error(f"pass '{step.task.name}'")
        for name, caller in (targets or {}).items():
            stage.copy(name, caller)
        if timer:
            self.times = timer.results()
        return {name: textures[name] for name in self.plan.outputs}

    def read(self, name: str) -> NDArray[Any]:
        """A resource of the plan as an array (h, w, channels), row 0 at the *bottom*: float32, or uint8 for 8-bit formats.

        Of resources of full size the part that was wanted.
        """
        index = next(i for i, step in enumerate(self.plan.steps) if name in step.writes)
        step = self.plan.steps[index]
        attachment = step.writes.index(name)
        components, dtype = FORMATS[step.task.writes[name].format]
        wide = "f1" if dtype == "f1" else "f4"
        inside = self._tester.inside if step.scale == 1 else None
        rect = inside or (0, 0, *step.size)
        # Four channels whatever the format: the only reading that OpenGL ES promises.
        data = self._targets[index].read(viewport=rect, components=4, attachment=attachment, dtype=wide)
        array = np.frombuffer(data, np.uint8 if wide == "f1" else np.float32)
        return array.reshape(rect[3], rect[2], 4)[..., :components]

    def release(self) -> None:
        """Free every texture and framebuffer. Calling it twice does no harm."""
        if self._owned:
            self.kit.home.use()
        for made in reversed(self._owned):
            made.release()
        self._owned = []
