"""What is made of a renderer's scene when a plan asks for it, and kept as long as the scene is: a tree for rays, a field of voxels."""

from __future__ import annotations

import time
from typing import Any

from ..gl.executor import SceneView
from ..gl.field_textures import FieldTextures
from ..gl.programs import GpuResources
from ..gl.scene_buffers import SceneBuffers
from ..graph.names import FIELD
from ..graph.plan import Plan
from ..occupancy.field import field_of
from ..pipeline.frame_setup import FrameSetup
from ..scene.camera import Camera
from ..scene.model import Scene
from .ray_hosts import RayHosts


class KeptOfScene:
    """Makes what a plan asks for beside the scene's buffers. The last tree is kept, and the last field, on the GPU alone."""

    def __init__(self, resources: GpuResources) -> None:
        self._resources, self._rays = resources, RayHosts()
        self._made: tuple[Scene, float, FieldTextures] | None = None
        self._cost = 0.0, 0

    def seen(self, plan: Plan, buffers: SceneBuffers, camera: Camera, made: FrameSetup) -> SceneView:
        """Return what the plan draws. Raises SceneError, and SettingsError without what traces rays."""
        hosts = self._rays.of(plan, buffers.scene, camera, made)
        return SceneView(buffers, camera, hosts, made.lit, self._field(plan, buffers.scene, made.settings.method))

    def _field(self, plan: Plan, scene: Scene, method: Any) -> FieldTextures | None:
        """Return the field of ``scene`` by the method's voxels; None for plans that read none. Raises SceneError."""
        if FIELD not in plan.inputs:
            return None
        side = float(method.side)
        if self._made is None or self._made[0] is not scene or self._made[1] != side:
            self._drop()
            began, made = time.perf_counter(), field_of(scene, side)
            self._made = scene, side, FieldTextures(self._resources, made)
            self._cost = 1e3 * (time.perf_counter() - began), made.bytes
        return self._made[2]

    def table(self, seen: SceneView) -> dict[str, Any]:
        """Return what the field of a view took to make, ms, and takes on the GPU, bytes; nothing where it has none."""
        return {"prepared": dict(zip(("ms", "bytes"), self._cost, strict=True))} if seen.field else {}

    def release(self) -> None:
        """Free the field, and forget the tree."""
        self._drop()
        self._rays = RayHosts()

    def _drop(self) -> None:
        if self._made is not None:
            self._made[2].release()
        self._made = None
