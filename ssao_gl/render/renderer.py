"""Headless rendering: a context, a scene in its memory, and pictures out of it, over many frames."""

from __future__ import annotations

import functools
import importlib.metadata
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Concatenate, ParamSpec, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from .. import gl, planner
from ..errors import ContextError
from ..gl.context import Context
from ..gl.executor import FrameExecutor
from ..gl.programs import GpuResources
from ..gl.scene_buffers import SceneBuffers
from ..gl.timer import PassTime
from ..graph.plan import Plan
from ..graph.regions import DrawRegion
from ..passes.denoise import Filter
from ..pipeline.build import plan_apply, plan_filter
from ..pipeline.frame_setup import frame_setup
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size, ViewConstants
from .arrays import check_arrays, check_size, radius_of
from .memory import check_room
from .picture import Picture
from .readback import read_aov, time_passes

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


@functools.cache
def _version() -> str:
    return importlib.metadata.version("ssao_gl")  # which reads a file


def _current(method: Callable[Concatenate[Renderer, Arguments], Result]) -> Callable[Concatenate[Renderer, Arguments], Result]:
    """Run a method with the renderer's context current, and leave a caller's own context as it was."""

    @functools.wraps(method)
    def on_own_context(self: Renderer, /, *given: Arguments.args, **named: Arguments.kwargs) -> Result:
        if self.ctx.released:
            raise ContextError("Renderer: was released; make another")
        with self.ctx.current():
            return method(self, *given, **named)

    return on_own_context


class Renderer:
    """Renders scenes, and applies occlusion to arrays, on one GL context that it opens or is given.

        with Renderer() as renderer:
            picture = renderer.render(scene, camera, (1280, 720))

    Keep it for many frames: programs, textures and the last scene stay on the GPU.
    """

    def __init__(self, provider: str | Context = "auto", *, keep: int = 1) -> None:
        """``keep``: how many plans' textures stay when settings change; more than 1 for those who go to and fro."""
        self.ctx = provider if isinstance(provider, Context) else gl.open(provider)
        self._opened = self.ctx is not provider
        try:
            with self.ctx.current():
                self._kit = GpuResources(self.ctx)
        except BaseException:
            if self._opened:
                self.ctx.release()
            raise
        if self._opened:
            self.ctx.leave()
        self._keep = keep
        self._frames: list[tuple[Any, FrameExecutor]] = []  # the last one used is last
        self._scene: SceneBuffers | None = None

    @_current
    def render(
        self,
        scene: Scene,
        camera: Camera | None = None,
        size: Size = (1280, 720),
        settings: Settings | None = None,
        *,
        aovs: Sequence[str] = ("image", "visibility"),
        timed: int = 0,
        checked: bool = False,
        budget_ms: float | None = None,
        max_error: float | None = None,
    ) -> Picture:
        """Draw ``scene``; without ``camera`` the scene's own first one, else an automatic view.

        ``aovs``: any of image, visibility, depth, normal, bent, color. ``timed`` draws that many frames more and reports the median
        milliseconds of each pass. ``budget_ms``, ``max_error``: method and options are chosen; see :func:`ssao_gl.planner.plan`.
        """
        if budget_ms is not None or max_error is not None:
            target = planner.Target(budget_ms=budget_ms, max_error=max_error)
            choice = planner.plan(self, scene, camera, size, target, settings, aovs=aovs)
            timed = max(timed, planner.ROUNDS)
            return choice.noted(self.render(scene, camera, size, choice.settings, aovs=aovs, timed=timed, checked=checked))
        settings, frame, view, where = self._ready(scene, camera, size, settings, aovs)
        started = time.perf_counter()
        frame.run(view, context=self._scene, **where, checked=checked)
        arrays = {name: read_aov(frame, name) for name in aovs}
        self._check("drawing")
        report = self._report(settings, size, frame, time.perf_counter() - started)
        report |= time_passes(frame, timed, view, context=self._scene, **where)
        used = self._scene.camera if self._scene else None
        return Picture(
            arrays,
            report | {"camera": (used.name if used else "") or "unnamed", "scene": scene.name, "triangles": scene.triangles},
        )

    @_current
    def time(
        self, scene: Scene, camera: Camera, size: Size, settings: Settings, *, aovs: Sequence[str] = ("image",)
    ) -> list[PassTime]:
        """Draw one frame with every pass timed, and read nothing back."""
        _, frame, view, where = self._ready(scene, camera, size, settings, aovs)
        frame.run(view, context=self._scene, **where, timed=True)
        return frame.times

    @_current
    def frame(
        self, scene: Scene, camera: Camera, size: Size, settings: Settings, *, aovs: Sequence[str] = ("image",)
    ) -> Callable[[], object]:
        """A function that draws the frame again and waits for nothing: what a loop of one's own would call."""
        _, frame, view, where = self._ready(scene, camera, size, settings, aovs)
        return lambda: frame.run(view, context=self._scene, **where)

    @_current
    def resource(
        self, scene: Scene, camera: Camera, size: Size, settings: Settings, name: str, *, aovs: Sequence[str] = ("visibility",)
    ) -> NDArray[Any] | None:
        """A resource of a drawn frame, as :meth:`FrameExecutor.read` gives it: row 0 at the bottom; None when the plan has none."""
        _, frame, view, where = self._ready(scene, camera, size, settings, aovs)
        if not any(name in step.writes for step in frame.plan.steps):
            return None
        frame.run(view, context=self._scene, **where)
        return frame.read(name)

    def _ready(
        self, scene: Scene, camera: Camera | None, size: Size, settings: Settings | None, aovs: Sequence[str]
    ) -> tuple[Settings, FrameExecutor, ViewConstants, DrawRegion]:
        """Everything on the GPU for a frame: the scene, its camera, the plan's textures; and which part of them is drawn."""
        camera = camera or (scene.cameras[0] if scene.cameras else scene.default_camera(size))
        self._show(scene, camera, size)
        made = frame_setup(scene, camera, size, settings or Settings(), self.ctx.max_size)
        frame = self._plan(("render", made.settings, made.outer, tuple(aovs), made.triangles), lambda: made.plan(aovs))
        return made.settings, frame, made.view, made.drawn

    def _show(self, scene: Scene, camera: Camera, size: Size) -> None:
        """The scene on the GPU, before this camera. Raises SettingsError for a size that cannot be."""
        check_size(size)
        if self._scene is None or self._scene.scene is not scene:
            if self._scene is not None:
                self._scene.release()
            self._scene = None
            made = SceneBuffers(self._kit, scene)
            try:
                self._check(f"storing {scene.name or 'the scene'}")  # to draw from buffers that could not be made may crash
            except ContextError:
                made.release()
                raise
            self._scene = made
        self._scene.camera = camera

    @_current
    def apply(
        self,
        depth: NDArray[Any],
        camera: Camera,
        *,
        color: NDArray[Any] | None = None,
        normals: NDArray[Any] | None = None,
        depth_kind: str = "eye",
        settings: Settings | None = None,
        aovs: Sequence[str] = ("visibility", "depth", "normal"),
        timed: int = 0,
        checked: bool = False,
        budget_ms: float | None = None,
        max_error: float | None = None,
    ) -> Picture:
        """Occlusion over arrays, row 0 on top.

        depth: (h, w) distance along the view axis in scene units (0, inf, nan: background), or window depth in 0..1.
        color: (h, w, 3 or 4) uint8 sRGB, to be dimmed. normals: (h, w, 3) view space. Gives ``aovs``, and image when
        there is colour. Raises FormatError for shapes that do not fit. ``timed``, ``budget_ms``, ``max_error``: see :meth:`render`.
        """
        if budget_ms is not None or max_error is not None:
            target = planner.Target(budget_ms=budget_ms, max_error=max_error)
            choice = planner.plan_arrays(
                self, depth, camera, target, settings, color=color, normals=normals, depth_kind=depth_kind
            )
            return choice.noted(
                self.apply(
                    depth, camera, color=color, normals=normals, depth_kind=depth_kind, settings=choice.settings, aovs=aovs,
                    timed=max(timed, planner.ROUNDS), checked=checked,
                )
            )  # fmt: skip
        depth, color, normals = check_arrays(depth, color, normals)
        h, w = depth.shape
        size = (w, h)
        settings = settings or Settings()
        if settings.method.radius is None:
            settings = settings.with_radius(camera.ao_radius or radius_of(depth, camera, depth_kind))
        outputs = (
            "visibility",
            "z",
            "normal",
            *(("bent",) if "bent" in aovs else ()),
            *(("image",) if color is not None else ()),
        )
        frame = self._plan(
            ("apply", settings, size, depth_kind, normals is not None, outputs),
            lambda: plan_apply(settings, size, depth=depth_kind, normals=normals is not None, outputs=outputs),
        )
        given = {"depth": depth, "normal_xyz": normals, "color": color}
        with self._uploaded({name: array for name, array in given.items() if array is not None}) as inputs:
            started = time.perf_counter()
            frame.run(camera.view(size), inputs, checked=checked)
            names = (*aovs, *(("image",) if color is not None else ()))
            arrays = {name: read_aov(frame, name, alpha=color is not None and color.shape[2] == 4) for name in names}
            self._check("drawing")
            report = self._report(settings, size, frame, time.perf_counter() - started)
            report |= time_passes(frame, timed, camera.view(size), inputs)
        return Picture(arrays, report)

    @_current
    def filter(
        self, scene: Scene, camera: Camera, size: Size, visibility: NDArray[Any], blur: Filter
    ) -> tuple[NDArray[np.float32], list[PassTime]]:
        """A visibility (h, w) from elsewhere, row 0 on top, filtered by the depth and normals of ``scene``; and the time
        that each pass took."""
        self._show(scene, camera, size)
        frame = self._plan(("filter", blur, size), lambda: plan_filter(blur, size))
        with self._uploaded({"given": check_arrays(visibility, None, None)[0]}) as inputs:
            frame.run(camera.view(size), inputs, context=self._scene, timed=True)
            return read_aov(frame, "visibility"), frame.times

    @contextmanager
    def _uploaded(self, arrays: Mapping[str, NDArray[Any]]) -> Iterator[dict[str, moderngl.Texture]]:
        """The caller's arrays as textures, for as long as the block lasts."""
        inputs: dict[str, moderngl.Texture] = {}
        try:
            for name, array in arrays.items():
                inputs[name] = self._kit.upload(array)
            yield inputs
        finally:
            for texture in inputs.values():
                texture.release()

    def _check(self, what: str) -> None:
        """Raise ContextError when OpenGL ran out of memory, or was lost. Errors of a caller's own context may be the caller's."""
        if self._opened:
            self.ctx.check_error(what)

    def _plan(self, key: Any, make: Any) -> FrameExecutor:
        """The frame for a plan; the last ones are kept, and their textures serve every plan of the same shape."""
        found = next((i for i, (kept, _) in enumerate(self._frames) if kept == key), None)
        if found is not None:
            self._frames.append(self._frames.pop(found))
            return self._frames[-1][1]
        plan: Plan = make()
        same = next((i for i, (_, frame) in enumerate(self._frames) if frame.plan == plan), None)
        if same is not None:
            frame = self._frames.pop(same)[1]
            frame.plan = plan  # other settings, the same targets
        else:
            while len(self._frames) >= self._keep:
                self._frames.pop(0)[1].release()
            if self.ctx.software:
                check_room(plan.bytes, plan.frame)
            frame = FrameExecutor(self._kit, plan)
        self._frames.append((key, frame))
        return frame

    def _report(self, settings: Settings, size: Size, frame: FrameExecutor, seconds: float) -> dict[str, Any]:
        return {
            "version": _version(),
            "settings": settings.table(),
            "size": list(size),
            "provider": self.ctx.provider,
            "platform": self.ctx.platform,
            "renderer": self.ctx.renderer,
            "gl_version": self.ctx.version,
            "plan": frame.plan.describe().splitlines(),
            "seconds": seconds,
        }

    def release(self) -> None:
        """Free everything, and the context if the renderer opened it. Calling it twice does no harm."""
        if self.ctx.released:
            return
        with self.ctx.current():
            if self._scene is not None:
                self._scene.release()
            for _, frame in self._frames:
                frame.release()
            self._scene, self._frames = None, []
            self._kit.release()
        if self._opened:
            self.ctx.release()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.release()
