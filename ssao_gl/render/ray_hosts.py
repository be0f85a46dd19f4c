"""Rays for the plans of a renderer: Embree's tree of its scene, kept as long as the scene is."""

from __future__ import annotations

from collections.abc import Mapping

from ..gl.executor import HostFunction
from ..graph.draws import HostWork
from ..graph.plan import Plan
from ..passes.residual import TRACE_RAYS
from ..pipeline.frame_setup import FrameSetup
from ..scene.camera import Camera
from ..scene.model import Scene
from ..truth.rays import RayScene
from ..truth.scattered import ScatteredRays


class RayHosts:
    """Makes what traces the rays of a plan. The tree of the last scene is kept."""

    def __init__(self) -> None:
        self._tree: RayScene | None = None

    def of(self, plan: Plan, scene: Scene, camera: Camera, made: FrameSetup) -> Mapping[str, HostFunction]:
        """Return who does the plan's work by its name; nothing for plans without. Raises SettingsError without embreex, SceneError."""
        if not any(isinstance(step.task.draw, HostWork) for step in plan.steps):
            return {}
        if self._tree is None or self._tree.scene is not scene:
            self._tree = None  # before the next one is built
            self._tree = RayScene(scene)
        return {TRACE_RAYS: ScatteredRays(self._tree, camera, made.corner, made.whole)}
