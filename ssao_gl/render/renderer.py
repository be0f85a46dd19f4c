"""Headless rendering: a context, a scene in its memory, and pictures out of it, over many frames."""

from __future__ import annotations

import functools
import time
import weakref
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Concatenate, NoReturn, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import gl
from ..errors import ContextError
from ..gl.context import Context
from ..gl.executor import FrameExecutor, SceneView
from ..gl.frame_cache import FrameCache
from ..gl.programs import GpuResources
from ..gl.scene_buffers import SceneBuffers
from ..gl.timer import PassTime
from ..graph import names
from ..graph.names import COLOR, GIVEN_DEPTH, GIVEN_HISTORY, GIVEN_NORMAL, HISTORY, IMAGE, VISIBILITY
from ..graph.plan import Plan
from ..io.images import flipped
from ..passes.denoise import Filter
from ..passes.temporal import Moment
from ..pipeline.build import check_camera, plan_apply, plan_filter
from ..pipeline.frame_setup import FrameSetup, frame_setup
from ..pipeline.outputs import aov_names
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.model import Scene
from ..scene.projection import Size, pixel_size
from .arrays import check_arrays, check_kinds, is_fine, radius_of, settled_depth
from .deprecated import drawn_to_budget
from .frame_report import frame_report, scene_report
from .history import History
from .kept_of_scene import KeptOfScene
from .memory import check_room
from .picture import Picture
from .readback import read_aov, time_passes
from .uploads import uploaded
from .upsampled import needs_upsampling, upsampled

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


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
                self._resources = GpuResources(self.ctx)
        except BaseException:
            if self._opened:
                self.ctx.release()
            raise
        if self._opened:
            self.ctx.leave()
        self._frames: FrameCache[Any] = FrameCache(self._resources, keep)
        self._scene: SceneBuffers | None = None
        self._kept = KeptOfScene(self._resources)
        if self._opened:
            weakref.finalize(self, self.ctx.release).atexit = False  # with a context go all of its objects

    @_current
    def render(
        self,
        /,
        scene: Scene,
        camera: Camera | None = None,
        size: Size = (1280, 720),
        settings: Settings | None = None,
        *,
        aovs: str | Sequence[str] = ("image", "visibility"),
        visibility_bits: int = 16,
        timed: int = 0,
        checked: bool = False,
        history: History | None = None,
        **budget: float | None,
    ) -> Picture:
        """Draw ``scene``; without ``camera`` the scene's own first one, else an automatic view.

        ``aovs``: any of image, visibility, depth, normal, bent, color; or one text with names by commas. ``visibility_bits``: 16
        (half floats) or 8 (as pictures have). ``timed`` draws that many frames more and reports the median
        milliseconds of each pass. ``history``: a sequence that this is the next frame of. ``budget``: ``budget_ms`` and ``max_error`` of 0.1, deprecated; plan with :func:`ssao_gl.plan` or :func:`ssao_gl.render`.
        """
        if draw := drawn_to_budget("render_planned", budget):
            return draw(self, scene, camera, size, settings=settings, aovs=aovs, timed=timed, checked=checked)
        size, aovs = pixel_size(size), aov_names(aovs)
        fine, moment = is_fine(visibility_bits, aovs), None if history is None else history.moment
        made, frame, seen = self._ready(scene, camera, size, settings, aovs, fine=fine, moment=moment)
        started = time.perf_counter()
        past = {} if history is None else {GIVEN_HISTORY: history.given(frame.plan.size_of(HISTORY))}
        with uploaded(self._resources, past) as inputs:
            then = None if history is None else history.uniforms(seen.camera)
            drawn = frame.run(made.view, inputs, scene=seen, region=made.region, moment=then, checked=checked)
            seen_through = made.settings.shading.background_rgba[3] < 1
            arrays = {name: read_aov(drawn, name, alpha=name == "image" and seen_through) for name in aovs}
            self._check("drawing")
            if history is not None:
                history.keep(flipped(drawn.read_all(HISTORY)), made.view, seen.camera)
            report = frame_report(self.ctx, made.settings, size, frame, time.perf_counter() - started)
            report |= time_passes(frame, timed, made.view, inputs, scene=seen, region=made.region)
        return Picture(arrays, {**report, **scene_report(scene, seen.camera, aovs), **self._kept.table(seen)})

    @_current
    def time(
        self, scene: Scene, camera: Camera, size: Size, settings: Settings, *, aovs: str | Sequence[str] = ("image",)
    ) -> Sequence[PassTime]:
        """Draw one frame with every pass timed, and read nothing back."""
        made, frame, seen = self._ready(scene, camera, size, settings, aovs)
        return frame.run(made.view, scene=seen, region=made.region, timed=True).times

    @_current
    def frame(
        self, scene: Scene, camera: Camera, size: Size, settings: Settings, *, aovs: str | Sequence[str] = ("image",)
    ) -> Callable[[], object]:
        """Return a function that draws the frame again and waits for nothing: what a loop of one's own would call."""
        made, frame, seen = self._ready(scene, camera, size, settings, aovs)

        def again() -> object:
            with self.ctx.current():
                return frame.run(made.view, scene=seen, region=made.region)

        return again

    @_current
    def resource(
        self,
        scene: Scene,
        camera: Camera,
        size: Size,
        settings: Settings,
        name: str,
        *,
        aovs: str | Sequence[str] = ("visibility",),
    ) -> NDArray[Any] | None:
        """Return a resource of a drawn frame, as :meth:`DrawnFrame.read` gives it: row 0 at the bottom; None when the plan has none."""
        made, frame, seen = self._ready(scene, camera, size, settings, aovs)
        if not any(name in step.writes for step in frame.plan.steps):
            return None
        return frame.run(made.view, scene=seen, region=made.region).read(name)

    def _ready(
        self,
        scene: Scene,
        camera: Camera | None,
        size: Size,
        settings: Settings | None,
        aovs: str | Sequence[str],
        *,
        fine: bool = False,
        moment: Moment | None = None,
    ) -> tuple[FrameSetup, FrameExecutor, SceneView]:
        """Put everything on the GPU for a frame: the scene, the plan's textures."""
        size, aovs = pixel_size(size), aov_names(aovs)
        check_kinds(scene, camera, settings)
        camera = camera or (scene.cameras[0] if scene.cameras else scene.default_camera(size))
        made = frame_setup(scene, camera, size, settings or Settings(), self.ctx.max_size)
        key = ("render", made.settings, made.outer, tuple(aovs), made.triangles, fine, moment)
        frame = self._frames.get(key, lambda: made.plan(aovs, fine=fine, moment=moment), self._check_room)
        return made, frame, self._kept.seen(frame.plan, self._uploaded_scene(scene), camera, made)

    def _uploaded_scene(self, scene: Scene) -> SceneBuffers:
        """Return the scene on the GPU."""
        if self._scene is None or self._scene.scene is not scene:
            if self._scene is not None:
                self._scene.release()
            self._scene = None
            made = SceneBuffers(self._resources, scene)
            try:
                self._check(f"storing {scene.name or 'the scene'}")  # to draw from buffers that could not be made may crash
            except ContextError:
                made.release()
                raise
            self._scene = made
        return self._scene

    @_current
    def apply(
        self,
        /,
        depth: NDArray[Any] | DepthImage,
        camera: Camera,
        *,
        color: NDArray[Any] | None = None,
        normals: NDArray[Any] | None = None,
        depth_kind: str = "eye",
        settings: Settings | None = None,
        aovs: str | Sequence[str] = ("visibility", "depth", "normal"),
        visibility_bits: int = 16,
        timed: int = 0,
        checked: bool = False,
        **budget: float | None,
    ) -> Picture:
        """Occlusion over arrays, row 0 on top.

        depth: (h, w) numbers of ``depth_kind``, or a :class:`ssao_gl.DepthImage`, which says what they are; without a
        surface, numbers are all open, with a warning. color: (h, w, 3 or 4) uint8 sRGB, to be dimmed; where it is larger
        than depth, all results are upsampled to its size. normals: (h, w, 3) view space. Gives ``aovs``, and image when there
        is colour. Raises FormatError for shapes that do not fit. Other options: see :meth:`render`.
        """
        if draw := drawn_to_budget("apply_planned", budget):
            given = {"color": color, "normals": normals, "depth_kind": depth_kind}
            return draw(self, depth, camera, settings=settings, **given, aovs=aovs, timed=timed, checked=checked)
        aovs = aov_names(aovs)
        depth, depth_kind = settled_depth(depth, depth_kind, camera)
        guide = color if needs_upsampling(color, depth, settings) else None
        depth, color, normals = check_arrays(depth, None if guide is not None else color, normals)
        size = depth.shape[::-1]
        settings = settings or Settings()
        if settings.method.radius is None:
            settings = settings.with_radius(camera.ao_radius or radius_of(depth, camera, depth_kind))
        outputs = (
            *(VISIBILITY, names.DEPTH, names.NORMAL),
            *((names.BENT_NORMAL,) if "bent" in aovs else ()),
            *((IMAGE,) if color is not None else ()),
        )
        view, fine = camera.view(size), is_fine(visibility_bits, aovs)
        check_camera(settings, view)
        frame = self._frames.get(
            ("apply", settings, size, depth_kind, normals is not None, outputs, fine),
            lambda: plan_apply(settings, size, depth=depth_kind, normals=normals is not None, outputs=outputs, fine=fine),
            self._check_room,
        )
        arrays_given = {GIVEN_DEPTH: depth, GIVEN_NORMAL: normals, COLOR: color}
        with uploaded(self._resources, {name: array for name, array in arrays_given.items() if array is not None}) as inputs:
            started = time.perf_counter()
            drawn = frame.run(view, inputs, checked=checked)
            shown = (*aovs, *(("image",) if color is not None else ()))
            arrays = {name: read_aov(drawn, name, alpha=color is not None and color.shape[2] == 4) for name in shown}
            self._check("drawing")
            report = frame_report(self.ctx, settings, size, frame, time.perf_counter() - started)
            report |= time_passes(frame, timed, view, inputs)
            if guide is not None:
                needed = {name: read_aov(drawn, name) for name in ("visibility", "depth")}
                arrays = upsampled(arrays, needed, guide, settings.shading.ambient)
        return Picture(arrays, report)

    @_current
    def filter(
        self, scene: Scene, camera: Camera, size: Size, visibility: NDArray[Any], blur: Filter
    ) -> tuple[NDArray[np.float32], Sequence[PassTime]]:
        """Filter a visibility (h, w) from elsewhere, row 0 on top, by the depth and normals of ``scene``.

        Returns it, and the time that each pass took.
        """
        size = pixel_size(size)
        seen = SceneView(self._uploaded_scene(scene), camera)
        frame = self._frames.get(("filter", blur, size), lambda: plan_filter(blur, size), self._check_room)
        with uploaded(self._resources, {names.GIVEN_VISIBILITY: check_arrays(visibility, None, None)[0]}) as inputs:
            drawn = frame.run(camera.view(size), inputs, scene=seen, timed=True)
            return read_aov(drawn, "visibility"), drawn.times

    def _check(self, what: str) -> None:
        """Raise ContextError when OpenGL ran out of memory, or was lost. Errors of a caller's own context may be the caller's."""
        if self._opened:
            self.ctx.check_error(what)

    def _check_room(self, plan: Plan) -> None:
        if self.ctx.software:
            check_room(plan.bytes, plan.frame)

    def release(self) -> None:
        """Free everything, and the context if the renderer opened it. Calling it twice does no harm."""
        if self.ctx.released:
            return
        if self.ctx.ownership.inherited:  # a child frees nothing that its parent draws with
            self.ctx.released = self._opened
            return
        with self.ctx.ownership.lock:  # no thread draws in between
            with self.ctx.current():
                if self._scene is not None:
                    self._scene.release()
                self._frames.clear()
                self._kept.release()
                self._scene = None
                self._resources.release()
            if self._opened:
                self.ctx.release()

    def __reduce__(self) -> NoReturn:
        """Raise ContextError for who pickles a renderer: a context cannot leave its process."""
        raise ContextError("Renderer: cannot be sent to another process; make one there")

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.release()
