"""Spheres in GL textures, and how they are drawn into a G-buffer: one triangle each, block by block, without vertex data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..graph.names import COLOR, NORMAL, SHADING_NORMAL
from ..scene.ball_culling import in_view, nearest_first
from ..scene.bounds import similarity_scale
from ..scene.projection import ViewConstants
from ..scene.sphere_blocks import SphereBlocks, sphere_blocks
from ..scene.spheres import Spheres
from .drawn_depth import DrawnDepth
from .programs import GpuResources, Program
from .scene_draw import SceneDraw

COLUMNS = 2048
"""Of the textures, which hold a sphere a texel."""
CORNERS = 3
MANY = 1 << 16
"""Spheres from which looking for hidden ones pays."""
INSTANCE = np.dtype([("model_view", "f4", (4, 4)), ("first", "i4")])
LARGEST = 3e38
"""Of 32-bit floats."""


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """Spheres on the GPU.

    blocks: of them, in the order of the texture. places: (k, 4, 4) float64 from there to the scene's middle, for each copy.
    balls: (k b, 4) around the blocks of each copy, one copy after another. instances: matrix and first sphere of what is
    drawn; copies: which copy that is of.
    """

    spheres: Spheres
    blocks: SphereBlocks
    data: moderngl.Texture
    colors: moderngl.Texture | None
    places: NDArray[np.float64]
    balls: NDArray[np.float64]
    instances: moderngl.Buffer
    copies: moderngl.Buffer


class SphereBuffers:
    """Spheres, placed about ``center`` (3,), in GL objects."""

    def __init__(self, resources: GpuResources, spheres: Sequence[Spheres], center: NDArray[np.float64]) -> None:
        self._resources = resources
        self._center = center
        self._owned: list[Any] = []
        self._drawn = DrawnDepth(resources)
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
        about = spheres.centers - middle
        blocks = sphere_blocks(about, spheres.radii)
        scales = np.array([similarity_scale(matrix) for matrix in places])
        balls = np.empty((len(places), len(blocks.balls), 4))
        balls[..., :3] = np.einsum("kij,bj->kbi", places[:, :3, :3], blocks.balls[:, :3]) + places[:, None, :3, 3]
        balls[..., 3] = blocks.balls[:, 3] * scales[:, None]
        data = np.column_stack([about, spheres.radii]).astype(np.float32)[blocks.order]
        colors = None if spheres.colors is None else self._texture(spheres.colors[blocks.order], "f1")
        instances = self._owning(
            self._resources.ctx.mgl.buffer(reserve=INSTANCE.itemsize * len(places) * len(blocks.balls), dynamic=True)
        )
        copies = self._owning(self._resources.ctx.mgl.buffer(reserve=4 * len(places) * len(blocks.balls), dynamic=True))
        return _Placed(spheres, blocks, self._texture(data, "f4"), colors, places, balls.reshape(-1, 4), instances, copies)

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
        """Draw all of them whose block may be in the image: many by waves, of which each leaves out what those before it hide."""
        for number, placed in enumerate(self._placed):
            if seen.leaves_out(placed.spheres):
                continue
            at = placed.balls.copy()
            at[:, :3] = placed.balls[:, :3] @ seen.from_center[:3, :3].T + seen.from_center[:3, 3]
            shown = np.flatnonzero(in_view(at, seen.view, seen.projection))
            if placed.blocks.size * len(shown) < MANY or seen.drawn_depth is None:
                self._draw_blocks(number, shown, seen)
                continue
            first, *others = (shown[wave] for wave in nearest_first(at[shown], seen.projection, seen.view.size))
            self._draw_blocks(number, first, seen)
            for wave in others:
                self._drawn.update(seen.drawn_depth())
                self._draw_blocks(number, wave, seen, self._drawn)

    def _draw_blocks(self, number: int, blocks: NDArray[np.intp], seen: SceneDraw, drawn: DrawnDepth | None = None) -> None:
        placed = self._placed[number]
        if not len(blocks):
            return
        copies, within = np.divmod(blocks, len(placed.blocks.balls))
        instances = np.empty(len(blocks), INSTANCE)
        instances["model_view"] = (seen.from_center @ placed.places).transpose(0, 2, 1)[copies]
        instances["first"] = within * placed.blocks.size
        placed.instances.write(instances)
        if seen.labels:
            placed.copies.write(copies.astype("i4"))
        array = self._array(number, self._program(placed, seen, drawn))
        array.render(moderngl.TRIANGLES, vertices=CORNERS * placed.blocks.size, instances=len(blocks))

    def _program(self, placed: _Placed, seen: SceneDraw, drawn: DrawnDepth | None) -> Program:
        """Return what draws them, ready but for the instances."""
        defines = {**_defines(placed, seen), **seen.defines, **({"DRAWN": 1} if drawn else {})}
        program = self._resources.program(*seen.draw.shaders["spheres"], defines)
        shared = {**seen.uniforms, **seen.view.constants, **_lens(seen.view)}
        program.set({name: value for name, value in shared.items() if name in program.declared})
        unit = seen.first_unit
        self._resources.bind(unit, placed.data)
        program.set({"u_spheres": unit, "u_columns": COLUMNS, **seen.label(placed.spheres)})
        if drawn:
            program.set(drawn.bound(unit + 2))
        if "COLOR" in seen.target_defines:
            program.set({"u_color": (*placed.spheres.color, 1.0)})
            if placed.colors is not None:
                self._resources.bind(unit + 1, placed.colors)
                program.set({"u_colors": unit + 1})
        return program

    def _array(self, number: int, program: Program) -> moderngl.VertexArray:
        array = self._arrays.get((number, program))
        if array is None:
            placed = self._placed[number]
            content: list[Any] = [(placed.instances, "16f 1i/i", "a_model_view", "a_first")]
            content += [(placed.copies, "1i/i", "a_copy")] if "a_copy" in program.mgl else []
            array = self._arrays[number, program] = self._resources.ctx.mgl.vertex_array(program.mgl, content)
        return array

    def release(self) -> None:
        """Free every texture and buffer."""
        for made in (*self._arrays.values(), *self._owned, self._drawn):
            made.release()
        self._arrays, self._owned, self._placed = {}, [], []


def _defines(placed: _Placed, seen: SceneDraw) -> dict[str, int]:
    """Return what the shader must do, and no more."""
    defines = dict(seen.target_defines)
    if {NORMAL, SHADING_NORMAL, COLOR} & seen.shown:
        defines["NORMAL"] = 1
    if placed.colors is not None and COLOR in seen.shown:
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
