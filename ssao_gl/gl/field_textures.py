"""The occupancy of a scene in 3-D textures."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from ..graph.names import FIELD, FIELD_COARSE
from ..occupancy.field import Field
from ..occupancy.grid import LEVELS
from ..occupancy.pyramid import level_starts
from ..scene.camera import Camera
from .programs import GpuResources
from .volume_buffers import largest_3d_texture


class FieldTextures:
    """A field on the GPU."""

    def __init__(self, resources: GpuResources, field: Field) -> None:
        """Raise SceneError for a field that is longer than 3-D textures may be."""
        self.grid, self.apart, self.lift = field.grid, field.apart, field.lift
        self.textures: dict[str, moderngl.Texture3D] = {}
        limit, longest = largest_3d_texture(resources), max(*field.finest.shape, *field.coarser.shape)
        if longest > limit:
            raise SceneError(
                f"field: {longest} voxels along a side; {resources.ctx.renderer} holds {limit}: give it larger ones, like field.voxel={field.grid.side * longest / limit:.3g}"
            )
        try:
            for name, array in ((FIELD, field.finest[..., None]), (FIELD_COARSE, field.coarser)):
                size, channels = array.shape[2::-1], array.shape[3]
                self.textures[name] = resources.ctx.mgl.texture3d(
                    size, channels, np.ascontiguousarray(array), alignment=1, dtype="f1"
                )
        except BaseException:
            self.release()
            raise

    def uniforms(self, camera: Camera) -> dict[str, Any]:
        """Return the uniforms that say where the voxels lie before ``camera``."""
        pose = np.asarray(camera.pose, np.float64)
        to_voxels: NDArray[np.float64] = self.grid.to_voxels @ pose
        eye = np.floor(to_voxels[:3, 3] / 2**LEVELS)  # the coarsest voxel that it is in
        to_voxels[:3, 3] -= eye * 2**LEVELS
        least = np.array([-eye * 2 ** (LEVELS - level) for level in range(LEVELS + 1)])
        last = least + [np.array(self.grid.shape) // 2**level - 1 for level in range(LEVELS + 1)]
        columns = {
            "u_least": _columns(least),
            "u_last": _columns(last),
            "u_place": _columns(level_starts(self.grid.shape) - least),
        }
        turns = {"u_to_field": tuple(to_voxels.T.ravel()), "u_to_axes": tuple(pose[:3, :3].T.ravel())}
        return {**turns, **columns, "u_apart": self.apart, "u_lift": self.lift}

    def release(self) -> None:
        """Free the textures."""
        for texture in self.textures.values():
            texture.release()
        self.textures = {}


def _columns(triples: ArrayLike) -> tuple[float, ...]:
    """Return a 4 x 4 matrix, column by column, of four triples (4, 3)."""
    return tuple(np.pad(np.asarray(triples, np.float64), ((0, 0), (0, 1))).ravel())
