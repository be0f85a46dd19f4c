"""Spheres in GL textures, and how they are drawn into a G-buffer: one triangle each, without vertex data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..graph.names import COLOR, NORMAL, SHADING_NORMAL
from ..scene.bounds import similarity_scale
from ..scene.projection import ViewConstants
from ..scene.spheres import Spheres
from .programs import GpuResources, Program
from .scene_draw import SceneDraw

COLUMNS = 2048
"""Of the textures, which hold a sphere a texel."""
CORNERS = 3
LARGEST = 3e38
"""Of 32-bit floats."""


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """Spheres on the GPU. places: (k, 4, 4) float64 from their texture to the scene's middle; balls: (k, 4) around each copy."""

    spheres: Spheres
    data: moderngl.Texture
    colors: moderngl.Texture | None
    places: NDArray[np.float64]
    balls: NDArray[np.float64]
    instances: moderngl.Buffer


class SphereBuffers:
    """Spheres, placed about ``center`` (3,), in GL objects."""

    def __init__(self, resources: GpuResources, spheres: Sequence[Spheres], center: NDArray[np.float64]) -> None:
        self._resources = resources
        self._center = center
        self._owned: list[Any] = []
        self._arrays: dict[tuple[int, Program], moderngl.VertexArray] = {}
        try:
            self._placed = [self._upload(one) for one in spheres]
        except BaseException:
            self.release()
            raise

    def _upload(self, spheres: Spheres) -> _Placed:
        # About their own middle, as meshes are: differences of large coordinates are taken here, in 64-bit.
        low, high = spheres.centers.min(0).astype(np.float64), spheres.centers.max(0).astype(np.float64)
        middle = (low + high) / 2
        places = spheres.transforms.copy()
        places[:, :3, 3] += places[:, :3, :3] @ middle - self._center
        reach = float(np.linalg.norm(high - low)) / 2 + float(spheres.radii.max())
        scales = np.array([similarity_scale(matrix) for matrix in places])
        balls = np.column_stack([places[:, :3, 3], reach * scales])
        data = np.column_stack([spheres.centers - middle, spheres.radii]).astype(np.float32)
        colors = None if spheres.colors is None else self._texture(spheres.colors, "f1")
        instances = self._owning(self._resources.ctx.mgl.buffer(reserve=64 * len(places), dynamic=True))
        return _Placed(spheres, self._texture(data, "f4"), colors, places, balls, instances)

    def _texture(self, rows: NDArray[Any], dtype: str) -> moderngl.Texture:
        """Return (n, 4) values as a texture of ``COLUMNS`` columns."""
        height = -(-len(rows) // COLUMNS)
        texels = np.zeros((height * COLUMNS, 4), rows.dtype)
        texels[: len(rows)] = rows
        texture: moderngl.Texture = self._owning(self._resources.ctx.mgl.texture((COLUMNS, height), 4, texels, dtype=dtype))
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return texture

    def _owning(self, made: Any) -> Any:
        self._owned.append(made)
        return made

    def draw(self, seen: SceneDraw) -> None:
        """Draw all of them whose copy may be in the image."""
        shared = {**seen.uniforms, **seen.view.constants, **_lens(seen.view)}
        unit = seen.first_unit
        for number, placed in enumerate(self._placed):
            copies = placed.places[_may_be_seen(placed.balls, seen)]
            if not len(copies):
                continue
            program = self._resources.program(*seen.draw.shaders["spheres"], {**_defines(placed, seen), **seen.defines})
            program.set({name: value for name, value in shared.items() if name in program.declared})
            self._resources.bind(unit, placed.data)
            program.set({"u_spheres": unit, "u_columns": COLUMNS})
            if "COLOR" in seen.target_defines:
                program.set({"u_color": (*placed.spheres.color, 1.0)})
                if placed.colors is not None:
                    self._resources.bind(unit + 1, placed.colors)
                    program.set({"u_colors": unit + 1})
            placed.instances.write(np.ascontiguousarray(copies.transpose(0, 2, 1), "f4"))
            array = self._array(number, program)
            array.render(moderngl.TRIANGLES, vertices=CORNERS * len(placed.spheres.centers), instances=len(copies))

    def _array(self, number: int, program: Program) -> moderngl.VertexArray:
        array = self._arrays.get((number, program))
        if array is None:
            content = [(self._placed[number].instances, "16f/i", "a_model")]
            array = self._arrays[number, program] = self._resources.ctx.mgl.vertex_array(program.mgl, content)
        return array

    def release(self) -> None:
        """Free every texture and buffer."""
        for made in (*self._arrays.values(), *self._owned):
            made.release()
        self._arrays, self._owned, self._placed = {}, [], []


def _defines(placed: _Placed, seen: SceneDraw) -> dict[str, int]:
    """Return what the shader must do, and no more."""
    defines = dict(seen.target_defines)
    if {NORMAL, SHADING_NORMAL, COLOR} & set(seen.writes):
        defines["NORMAL"] = 1
    if placed.colors is not None and COLOR in seen.writes:
        defines["VERTEX_COLOR"] = 1
    return defines


def _lens(view: ViewConstants) -> dict[str, Any]:
    """Return the uniforms of a lens: its eye, or the direction of its parallel rays; the clip planes; the size of a pixel."""
    c = view.constants
    if view.w1:
        depth = -view.w0 / view.w1
        # All rays meet where w is 0.
        at = np.asarray(c["u_ray0"]) * depth + np.asarray(c["u_org0"])
        eye = (float(at[0]), float(at[1]), -depth, 1.0)
    else:
        eye = (*c["u_ray0"], -1.0, 0.0)
    far = view.far if math.isfinite(view.far) else LARGEST
    return {"u_eye": eye, "u_near_far": (view.near, min(far, LARGEST)), "u_pixel": view.pixel}


def _may_be_seen(balls: NDArray[np.float64], seen: SceneDraw) -> NDArray[np.bool_]:
    """Which balls (k, 4) about the scene's middle reach into the view."""
    view, middle, reach = seen.view, balls[:, :3], balls[:, 3]
    at = middle @ seen.from_center[:3, :3].T + seen.from_center[:3, 3]
    inside = (-at[:, 2] + reach >= view.near) & (-at[:, 2] - reach <= view.far)
    rows = view.projection
    for axis in (0, 1):
        for side in (1, -1):
            plane = rows[3] + side * rows[axis]
            inside &= at @ plane[:3] + plane[3] >= -reach * np.linalg.norm(plane[:3])
    return np.asarray(inside)
