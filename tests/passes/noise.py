"""A noise drawn over a scene, for filters to be compared with their formulas; lenses to look through."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import ssao_gl as ao
from ssao_gl.gl.executor import FrameExecutor, SceneView
from ssao_gl.gl.programs import GpuResources
from ssao_gl.gl.scene_buffers import SceneBuffers
from ssao_gl.graph.declare import Pass, Texture
from ssao_gl.graph.draws import Fullscreen
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.names import DEPTH, DEPTH_SMALL, NORMAL, NORMAL_SMALL, VISIBILITY_RAW
from ssao_gl.passes.gbuffer import gbuffer
from ssao_gl.passes.resolution import downsample
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import sphere


def off_centre(lens: ao.Camera, away: float = 0.0) -> ao.Camera:
    """Rays of sight that do not run along the axis, also where they are parallel; what is on it, so far away, stays in the middle."""
    matrix = lens.lens.matrix(SMALL).copy()
    matrix[:2, 2] += [0.06, -0.05]
    matrix[:2, 3] += np.multiply([0.06, -0.05], away)
    return ao.Camera.from_matrix(matrix)


SMALL = (96, 72)
AWAY = 20.0
LENSES = {
    "perspective": ao.Camera.perspective(0.9, 0.1, 500.0),
    "wide": ao.Camera.perspective(2.0, 0.1, 500.0),
    "parallel": ao.Camera.orthographic(4.0, 0.0, 500.0),
    "oblique": off_centre(ao.Camera.orthographic(4.0, 0.0, 500.0), AWAY),
    "off-centre": off_centre(ao.Camera.perspective(0.9, 0.1, 500.0)),
}
NOISE = f"{__name__.rpartition('.')[0]}.shaders:tile_noise.frag"


def ball(lens: str) -> Scene:
    """A ball that nearly fills the picture."""
    away = {"wide": 1.3, "perspective": 2.9, "off-centre": 2.9}.get(lens, AWAY)
    positions, triangles, _ = sphere(64)
    size = 1.7 if lens in ("parallel", "oblique") else 1.0
    return Scene([Mesh((positions * size - [0, 0, away]).astype(np.float32), triangles)])


def noise_through(
    provider: str, passes: Sequence[Pass], outputs: Sequence[str], scene: Scene, cam: ao.Camera, scale: int
) -> dict[str, np.ndarray]:
    """Resources by name, row 0 at the bottom: ``outputs``, and all that filters read of a noise of tiles of 4x4 texels."""
    smaller = [] if scale == 1 else [downsample(scale, open_blocks=False)]
    draw = Fullscreen(NOISE, {"u_z": DEPTH if scale == 1 else DEPTH_SMALL}, defines={"PACKED": 1})
    noise = Pass("noise", "occlusion", draw, {VISIBILITY_RAW: Texture("r32f", 1 / scale)})
    given = [VISIBILITY_RAW, DEPTH, NORMAL, *([NORMAL_SMALL] if smaller else [])]
    plan = compile([gbuffer((1.0, 1, 1), geometric=True), *smaller, noise, *passes], SMALL, [*outputs, *given])
    with ao.gl.open(provider) as ctx:
        resources = GpuResources(ctx)
        buffers, executor = SceneBuffers(resources, scene), FrameExecutor(resources, plan)
        frame = executor.run(cam.view(SMALL), scene=SceneView(buffers, cam), checked=True)
        return {name: frame.read(name) for name in (*outputs, *given)}


def decoded(encoded: np.ndarray) -> np.ndarray:
    """Normals (h, w, 3), as ``lib/normal.glsl`` encodes them."""
    n = encoded[..., :2].astype(np.float64)
    f = (n**2).sum(-1, keepdims=True)
    return np.concatenate([n * np.sqrt(1 - f / 4), 1 - f / 2], -1)


def unpacked(texels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Visibility and depth, as ``lib/output.glsl`` packs them."""
    bits = np.ascontiguousarray(texels, np.float32).view(np.uint32)
    return (bits & 0xFF) / 255, (bits & 0xFFFFFF00).view(np.float32).astype(np.float64)


def visibility(texels: np.ndarray) -> np.ndarray:
    """That of a packed resource, or of one of 8 bits."""
    return texels[..., 0] / 255 if texels.dtype == np.uint8 else unpacked(texels[..., 0])[0]


def points(z: np.ndarray, cam: ao.Camera, scale: int) -> np.ndarray:
    """View-space points (h, w, 3) of texels with linear depth z, each where the first of its pixels lies."""
    h, w = z.shape
    c = cam.view(SMALL).constants
    uv = np.stack(np.meshgrid((np.arange(w) * scale + 0.5) / SMALL[0], (np.arange(h) * scale + 0.5) / SMALL[1]), -1)
    ray, org = (np.reshape(c[name], (2, 2)) for name in ("u_ray", "u_org"))
    return np.concatenate([(uv @ ray + c["u_ray0"]) * z[..., None] + uv @ org + c["u_org0"], -z[..., None]], -1)


def tolerance(z: np.ndarray, cam: ao.Camera, texels: float, scale: int) -> np.ndarray:
    """So many texels, in scene units, at linear depth z."""
    view = cam.view(SMALL)
    return texels * scale * view.pixel * np.maximum(view.w1 * z + view.w0, 1e-30)
