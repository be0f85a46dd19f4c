"""Volumes in 3-D textures, and how they are drawn into a G-buffer: by rays, in a triangle over all of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..graph.draws import FloatTable
from ..graph.names import COLOR, NORMAL, SHADING_NORMAL
from ..scene.proximity import proximity
from ..scene.volume import Volume
from .programs import GpuResources
from .scene_draw import SceneDraw

GL_MAX_3D_TEXTURE_SIZE = 0x8073

FINER_STEPS = 10
"""More than the finer steps by which ``lib/opacity_ray.glsl`` looks for a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class _OnGpu:
    """A volume, its field in 32-bit floats, and how far rays may leap."""

    volume: Volume
    field: moderngl.Texture3D
    leaps: moderngl.Texture3D


class VolumeBuffers:
    """Fields of volumes, placed about ``center`` (3,), in GL textures."""

    def __init__(self, resources: GpuResources, volumes: Sequence[Volume], center: NDArray[np.float64]) -> None:
        """Raise SceneError for a volume that the driver has no room for."""
        self._resources = resources
        self._center = center
        self._owned: list[moderngl.Texture3D] = []
        self._volumes: list[_OnGpu] = []
        limit = largest_3d_texture(resources)
        for volume in volumes:
            _check_size(volume, limit, resources.ctx.renderer)
        try:
            for volume in volumes:
                field = self._texture(volume.field, "f4")
                self._volumes.append(_OnGpu(volume, field, self._texture(proximity(volume), "f1")))
        except BaseException:
            self.release()
            raise

    def _texture(self, array: NDArray[Any], dtype: str) -> moderngl.Texture3D:
        data = np.ascontiguousarray(array)
        texture = self._resources.ctx.mgl.texture3d(array.shape[::-1], 1, data, alignment=1, dtype=dtype)
        self._owned.append(texture)
        return texture

    def draw(self, seen: SceneDraw) -> None:
        """Draw every volume."""
        vertex, fragment = seen.draw.shaders["volume"]
        for on_gpu in self._volumes:
            if seen.leaves_out(on_gpu.volume):
                continue
            program = self._resources.program(vertex, fragment, {**_defines(on_gpu.volume, seen), **seen.defines})
            values = {
                **seen.uniforms,
                **ray_constants(on_gpu.volume, seen, self._center),
                **_look(on_gpu.volume),
                **seen.label(on_gpu.volume),
                "u_texel": seen.view.constants["u_texel"],
                "u_test_depth": 0.0,
            }
            for unit, (name, texture) in enumerate(self._textures(on_gpu), seen.first_unit):
                self._resources.bind(unit, texture)
                values[name] = unit
            program.set({name: value for name, value in values.items() if name in program.declared})
            self._resources.corners(program).render(moderngl.TRIANGLES)

    def _textures(self, on_gpu: _OnGpu) -> list[tuple[str, Any]]:
        """Return the names of samplers with their textures."""
        both = [("u_field", on_gpu.field), ("u_leaps", on_gpu.leaps)]
        if on_gpu.volume.transfer is None:
            return both
        return [*both, ("u_transfer", self._resources.table(FloatTable.of(on_gpu.volume.transfer_of().table()[None])))]

    def release(self) -> None:
        """Free every texture."""
        for texture in self._owned:
            texture.release()
        self._owned, self._volumes = [], []


def largest_3d_texture(resources: GpuResources) -> int:
    """Return the texels that a 3-D texture may have along each side; OpenGL ES promises 256."""
    return resources.ctx.functions.integers(GL_MAX_3D_TEXTURE_SIZE)[0]


def _defines(volume: Volume, seen: SceneDraw) -> dict[str, int]:
    """Return what the shader must do, and no more."""
    defines = seen.target_defines | ({"TRANSFER": 1} if volume.transfer is not None else {})
    exact = "GEOMETRIC" in seen.defines and volume.transfer is None
    smooth = {SHADING_NORMAL, COLOR} | (set() if exact else {NORMAL})
    if NORMAL in seen.shown or smooth & seen.shown:
        defines["NORMAL"] = 1
    if smooth & seen.shown:
        defines["SMOOTH"] = 1
    return defines


def _look(volume: Volume) -> dict[str, Any]:
    """Return the uniforms that say what is seen of a volume, and how far rays may have to go."""
    first, end = volume.occupied
    cells = int(np.sum(end - first)) + 3
    look = {"u_first": tuple(map(float, first)), "u_end": tuple(map(float, end)), "u_most": cells, "u_color": volume.color}
    if volume.transfer is None:
        return look
    longest = float(np.linalg.norm(end - first))
    return look | {
        "u_most": cells + math.ceil(longest / volume.transfer.step) + FINER_STEPS,
        "u_march": (volume.transfer.step, volume.transfer.unit or volume.voxel),
        "u_place": tuple(volume.affine[:3, :3].T.ravel()),
    }


def ray_constants(volume: Volume, seen: SceneDraw, center: NDArray[np.float64]) -> dict[str, Any]:
    """Return the uniforms of ``volume.frag`` that say where the ray of a pixel goes, in coordinates of the field.

    Rays are measured from the plane through the middle of the volume, in 64-bit, so that an eye far away costs nothing. A
    step is one voxel of depth.
    """
    middle, to_voxels = volume.bounds.mean(0), np.linalg.inv(volume.to_world[:3, :3])
    turn = seen.from_center[:3, :3]
    middle_view = turn @ (middle - center) + seen.from_center[:3, 3]
    depth = -float(middle_view[2])
    # Columns for u, v and 1: view-space xy of a pixel is (ray uv + ray0) depth + (org uv + org0).
    ray, org = (
        np.column_stack([np.reshape(seen.view.constants[f"u_{name}"], (2, 2)).T, seen.view.constants[f"u_{name}0"]])
        for name in ("ray", "org")
    )
    start, step = np.vstack([ray * depth + org, [0, 0, -depth]]), np.vstack([ray, [0, 0, -1]])
    start[:, 2] -= middle_view
    back = to_voxels @ turn.T
    start, step = back @ start, back @ step * volume.voxel
    start[:, 2] += to_voxels @ (middle - volume.to_world[:3, 3])
    near, far = ((plane - depth) / volume.voxel for plane in (seen.view.near, seen.view.far))
    return {
        "u_ray_start": tuple(start.T.ravel()),
        "u_ray_step": tuple(step.T.ravel()),
        "u_ray_depth": (depth, volume.voxel),
        "u_ray_range": (max(near, -1e30), min(far, 1e30)),
        "u_gradient": tuple((back * volume.voxel).ravel()),
    }


def _check_size(volume: Volume, limit: int, renderer: str) -> None:
    """Raise SceneError for a volume longer than 3-D textures may be."""
    longest = max(volume.array.shape)
    if longest + 2 > limit:
        step = -(-longest // (limit - 2))
        raise SceneError(
            f"{volume.name or 'the volume'}: {' x '.join(map(str, volume.array.shape))} voxels; {renderer} holds {limit - 2}"
            f" along each side: take every {step}. of them, like Volume(array[::{step}, ::{step}, ::{step}], affine)"
        )
