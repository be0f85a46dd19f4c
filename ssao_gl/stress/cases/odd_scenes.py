"""Scenes with something odd in them: strays, no extent, cut-outs, textures of awkward sizes; lenses beside their axis; raw bits."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from ...scene.camera import Camera
from ...scene.material import AlphaMode, ColorTexture, Material, Wrap
from ...scene.model import Mesh, Scene
from ...scene.sample_scene import default_scene
from ..analytic_depth import cast, room
from ..case import case
from ..runner import CaseRunner
from ..shapes import corner, lens, plane

GROUP = "odd scenes"
ALL = "share of pixels that differ at all"
SIZES = ((1, 1), (1, 7), (3, 1), (5, 3), (31, 17), (64, 64))
WRAPS: tuple[Wrap, ...] = ("repeat", "mirror", "clamp")


@case("stray-vertices", GROUP, ALL, 0.0, traps=(28,), why="the same bytes")
def strays(lab: CaseRunner) -> float:
    """Vertices that no triangle names, anywhere, change nothing, also of the automatic camera and radius."""
    scene = default_scene()
    far = np.array([[1e9, -1e9, 1e9], [0, 1e12, 0]], np.float32)
    meshes = [
        dataclasses.replace(
            mesh, positions=np.concatenate([mesh.positions, far]),
            normals=None if mesh.normals is None else np.concatenate([mesh.normals, far]),
        )
        for mesh in scene.meshes
    ]  # fmt: skip
    strayed = Scene(meshes, up=scene.up)
    a, b = (lab.render(s, s.default_camera(), radius=None).visibility for s in (Scene(scene.meshes, up=scene.up), strayed))
    return float((a != b).mean())


@case("no-extent", GROUP, "1 - darkest pixel", contract="plane", traps=(28,))
def no_extent(lab: CaseRunner) -> float:
    """Scenes of one point, of one line and of one plane seen edge on, with automatic camera and radius, are open."""
    triangle = np.array([[0, 1, 2]], np.uint32)
    darkest = 0.0
    for corners in (
        [[0, 0, 0]] * 3,
        [[0.85, 0, -0.5]] * 3,
        [[3e8, 3e8, 3e8]] * 3,
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [1e-17, 0, 0], [0, 0, 1e-17]],
    ):
        scene = Scene([Mesh(np.array(corners, np.float32), triangle)])
        darkest = max(darkest, lab.render(scene, scene.default_camera(), radius=None).darkest)
    return darkest


def _most_changed(lab: CaseRunner, changed: Callable[[int, Scene, int, int], Sequence[Mesh]]) -> float:
    """Return the largest share of pixels that differ from a corner's when it is ``changed`` for a texture of each size."""
    scene = corner()
    expected = lab.render(scene, lens()).visibility
    seen = (lab.render(Scene(changed(n, scene, *size)), lens()).visibility for n, size in enumerate(SIZES))
    return max(float((one != expected).mean()) for one in seen)


@case("holes-of-any-texture", GROUP, ALL, 0.0, contract="holes-of-any-texture", traps=(28,), why="the same bytes")
def holes(lab: CaseRunner) -> float:
    """Walls whose textures, of any size and wrapping, are cut out wherever they are seen change no byte of what is behind."""

    def behind_a_hole(number: int, scene: Scene, h: int, w: int) -> Sequence[Mesh]:
        texture = ColorTexture(np.full((h, w, 4), 255, np.uint8), (WRAPS[number % 3],) * 2)
        mode: AlphaMode = "BLEND" if number % 2 else "MASK"
        wall = plane(0.2, 3.0 + 0.2 * number).meshes[0]
        # A triangle out of sight is opaque by its colours: else the wall would be left out as a whole, and no alpha looked at.
        positions = np.concatenate([wall.positions, [[0, 0, 1], [0, 1, 1], [1, 0, 1]]]).astype(np.float32)
        faces = np.concatenate([wall.triangles, [[4, 5, 6]]]).astype(np.uint32)
        colors = np.zeros((7, 4), np.uint8)
        colors[4:] = 255
        uv = np.linspace(-1e4, 1e4, 14).reshape(-1, 2).astype(np.float32)
        material = Material(base_color_texture=texture, alpha_mode=mode)
        cut = Mesh(positions, faces, vertex_colors=colors, uv=uv, material=material)
        return [cut, *scene.meshes]

    return _most_changed(lab, behind_a_hole)


@case("textures-of-odd-sizes", GROUP, ALL, 0.0, traps=(28,), why="the same bytes")
def odd_textures(lab: CaseRunner) -> float:
    """Pictures of any size on a wall, at coordinates up to 1e25, leave occlusion as it is."""

    def painted(number: int, scene: Scene, h: int, w: int) -> Sequence[Mesh]:
        texture = ColorTexture(np.full((h, w, 4), 255, np.uint8), (WRAPS[number % 3],) * 2, nearest=bool(number % 2))
        material = Material(base_color_texture=texture, alpha_mode="MASK")
        uv = (np.eye(4, 2) * 10.0 ** (5 * number)).astype(np.float32)
        return [dataclasses.replace(mesh, uv=uv, material=material) for mesh in scene.meshes]

    return _most_changed(lab, painted)


@case("widest", GROUP, "difference of means", 1.0, traps=(13, 18), why="finite is what is asked")
def widest(lab: CaseRunner) -> float:
    """Fields of view from 179.91 to 179.999 degrees keep what every picture promises."""
    for degrees in (179.91, 179.99, 179.999):
        camera = Camera.perspective(math.radians(degrees), 0.1, 100.0)
        lab.apply(cast(camera, lab.size, *room()), camera)
        lab.render(corner(), camera)
    return 0.0


@case("axis-outside", GROUP, "difference of means", 1.0, traps=(35,), why="finite is what is asked")
def axis_outside(lab: CaseRunner) -> float:
    """Lenses shifted so far that their axis lies outside the image keep what every picture promises."""
    for shift in (1.5, -4.0, 60.0):
        m = np.array(lens().lens.matrix(lab.size))
        m[0, 2], m[1, 2] = shift, -shift / 2
        camera = Camera.from_matrix(m)
        lab.render(corner(), camera)
        lab.apply(cast(camera, lab.size, *room()), camera)
    return 0.0


@case("raw-bits", GROUP, "1 - mean visibility", 1.0, traps=(28,), why="finite is what is asked")
def raw_bits(lab: CaseRunner) -> float:
    """Depth of random bits, read as 32-bit floats, keeps what every picture promises."""
    w, h = lab.size
    for seed in range(4):
        bits = np.random.default_rng(seed).integers(0, 2**32, (h, w), np.uint32).view(np.float32)
        lab.apply(bits, lens(), blur="joint" if seed % 2 else "none")
    return 0.0
