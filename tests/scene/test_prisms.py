"""How much prisms fill, told beforehand, against what is drawn."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.gl.executor import FrameExecutor, SceneView
from ssao_gl.gl.scene_buffers import SceneBuffers
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.names import HIDDEN
from ssao_gl.passes.elements import add_elements
from ssao_gl.passes.gbuffer import gbuffer
from ssao_gl.scene.prisms import placed_triangles, prism_fill

SIZE = (96, 72)


@pytest.mark.parametrize("both", [True, False])
@pytest.mark.parametrize("radius", [0.02, 0.3])
def test_the_estimate_is_what_is_drawn(any_renderer: ao.Renderer, embedded: ao.Scene, radius: float, both: bool) -> None:
    """Within a quarter."""
    method = dataclasses.replace(ao.method("aov"), radius=radius, scale=1, sides="both" if both else "front")
    (prisms,) = add_elements(method, 1)
    counted = dataclasses.replace(
        prisms, draw=dataclasses.replace(prisms.draw, shaders=("prisms.vert", "tests.gl.shaders:ones.frag"))
    )
    camera, plan = embedded.cameras[0], compile([gbuffer((1, 1, 1), geometric=True), counted], SIZE, [HIDDEN])
    view = camera.view(SIZE)
    with any_renderer.ctx.current():
        buffers = SceneBuffers(any_renderer._resources, embedded)
        executor = FrameExecutor(any_renderer._resources, plan)
        drawn = float(executor.run(view, scene=SceneView(buffers, camera), checked=True).read(HIDDEN).sum())
        executor.release()
        buffers.release()
    estimate = prism_fill(embedded, camera, view, SIZE, radius, both_sides=both)
    assert 0.75 < estimate / drawn < 1.25


def test_triangles_are_placed_and_those_without_area_left_out() -> None:
    corners = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    places = np.stack([np.eye(4), np.diag([-1.0, 1, 1, 1])])
    mesh = ao.Scene.from_arrays(corners, [[0, 1, 2], [0, 1, 3]]).meshes[0]
    scene = ao.Scene([dataclasses.replace(mesh, transforms=places)])
    first, mirrored = (corners for corners, _, _ in placed_triangles(scene))
    middle = scene.bounds.mean(0)
    assert np.allclose(first + middle, [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    facing = np.cross(mirrored[0, 1] - mirrored[0, 0], mirrored[0, 2] - mirrored[0, 0])
    assert np.allclose(mirrored[0].min(0) + middle, [-1, 0, 0]) and facing[2] > 0
