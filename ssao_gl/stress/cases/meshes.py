"""Meshes as they come: broken, doubled, mirrored, squashed, thin."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ...scene.model import Mesh, Scene
from ...scene.sample_scene import cylinder, default_scene, place
from ..case import case
from ..runner import CaseRunner
from ..shapes import QUAD, lens, plane
from ..shot import share

GROUP = "meshes"
OFF = "share of pixels off by over 1/255"


@case("nan-vertices", GROUP, "meshes that are not refused", 0.0, traps=(28,), why="a refusal in words", once=True)
def nan_vertices(lab: CaseRunner) -> float:
    """A mesh with NaN or infinite vertices or transforms is refused in one line."""
    good = np.zeros((3, 3), np.float32)
    triangle = np.array([[0, 1, 2]], np.uint32)
    taken = 0
    for value in (np.nan, np.inf, -np.inf):
        bad = good.copy()
        bad[1, 1] = value
        for positions, transform in ((bad, np.eye(4)), (good, np.diag([1, value, 1, 1]))):
            try:
                Mesh(positions, triangle, transforms=transform[None])
                taken += 1
            except SceneError as refusal:
                taken += "finite" not in str(refusal)
    return float(taken)


@case("degenerate-triangles", GROUP, "share of pixels that differ at all", 0.0, traps=(28,), why="the same bytes")
def degenerate(lab: CaseRunner) -> float:
    """Triangles without area, with doubled corners, draw nothing and spoil nothing."""
    scene = default_scene()
    first = scene.meshes[0]
    flat_ones = np.array([[0, 0, 0], [0, 1, 1], [2, 1, 2]], np.uint32)
    more = dataclasses.replace(first, triangles=np.concatenate([flat_ones, first.triangles, flat_ones]))
    a, b = (lab.render(Scene(draws), scene.cameras[0]).visibility for draws in (scene.meshes, [more, *scene.meshes[1:]]))
    return float((a != b).mean())


@case("nan-mesh-normals", GROUP, OFF, 0.0, traps=(28, 32), why="missing normals are the triangles' own")
def nan_normals(lab: CaseRunner) -> float:
    """Mesh normals that are NaN or zero give way to the triangles' own."""
    bare = plane(0.4)
    pictures = [lab.render(bare, lens(), normals_of="shading").visibility]
    for value in (np.nan, 0.0, np.inf):
        normals = np.full((4, 3), value, np.float32)
        scene = Scene([dataclasses.replace(bare.meshes[0], normals=normals)])
        pictures.append(lab.render(scene, lens(), normals_of="shading").visibility)
    return max(share(pictures[0], other) for other in pictures[1:])


@case("doubled-faces", GROUP, "1 - darkest pixel", contract="plane", traps=(36,))
def doubled(lab: CaseRunner) -> float:
    """A plane drawn twice, a second time with its winding reversed, is open."""
    one = plane(0.5).meshes[0]
    return lab.render(Scene([one, one, dataclasses.replace(one, triangles=QUAD[:, ::-1].copy())]), lens()).darkest


@case("z-fighting", GROUP, "1 - darkest pixel", contract="plane", traps=(36,))
def fighting(lab: CaseRunner) -> float:
    """Two planes that fight for every pixel, 1e-7 of the distance apart, are open."""
    a, b = plane(0.5).meshes[0], plane(0.5, away=5 * (1 + 1e-7)).meshes[0]
    turned = dataclasses.replace(b, transforms=place((1, 1, 1), (0, 0, 0))[None])
    return lab.render(Scene([a, turned]), lens(), blur="joint").darkest


@case(
    "squashed-and-mirrored",
    GROUP,
    OFF,
    0.02,
    contract="scale",
    traps=(32,),
    why="edges may round to the next pixel, in a smaller image too",
)
def squashed(lab: CaseRunner) -> float:
    """Meshes under non-uniform and mirrored transforms look as when their vertices were moved instead, by either normals."""
    scene = default_scene()
    squash = np.diag([1.3, 0.4, -0.8, 1.0])  # mirrored
    worst = 0.0
    for normals_of in ("geometric", "shading"):
        moved = [dataclasses.replace(d, transforms=squash @ d.transforms) for d in scene.meshes]
        baked = [_baked(d, squash @ k) for d in scene.meshes for k in d.transforms]
        a, b = (lab.render(Scene(draws), scene.cameras[0], normals_of=normals_of).visibility for draws in (moved, baked))
        worst = max(worst, share(a, b))
    return worst


def _baked(draw: Mesh, matrix: NDArray[np.float64]) -> Mesh:
    """The mesh with a transform applied to its vertices and, by the inverse transpose, to its normals."""
    positions = draw.positions @ matrix[:3, :3].T + matrix[:3, 3]
    assert draw.normals is not None
    normals = draw.normals @ np.linalg.inv(matrix[:3, :3])
    return dataclasses.replace(
        draw, positions=positions.astype(np.float32), normals=normals.astype(np.float32), transforms=np.eye(4)[None]
    )


@case("order-of-triangles", GROUP, OFF, 0.002, traps=(36, 41), why="where triangles meet, either may win the pixel")
def order(lab: CaseRunner) -> float:
    """The order of meshes and of their triangles does not matter."""
    scene = default_scene()
    random = np.random.default_rng(4)
    shuffled = [dataclasses.replace(d, triangles=random.permutation(d.triangles)) for d in reversed(scene.meshes)]
    a, b = (lab.render(Scene(draws), scene.cameras[0]).visibility for draws in (scene.meshes, shuffled))
    return share(a, b)


@case(
    "thin-wire",
    GROUP,
    "mean darkness beyond the closed form",
    0.1,
    contract="thin",
    traps=(37,),
    why="depth shows no back: what a wall behind the wire, as wide and without end, would take",
)
def wire(lab: CaseRunner) -> float:
    """A thin wire casts no halo: from the wall behind it it takes the light that it covers, r h / (x^2 + h^2), and little more."""
    r, h, away = 0.06, 0.6, 5.0
    shaft = Mesh(*cylinder(24), transforms=(place((1, 1, 1), (0, 0, -away + h)) @ np.diag([r, 20, r, 1.0]))[None])
    seen = lab.render(Scene([plane(away=away).meshes[0], shaft]), lens(), radius=0.8, blur="joint")
    points = lens().view((seen.depth.shape[1], seen.depth.shape[0])).points(seen.depth)
    wall = np.abs(points[..., 2] + away) < 1e-3
    x = points[..., 0]
    expected = 1 - np.where(x**2 + h**2 < 0.8**2, r * h / (x**2 + h**2), 0)
    return float((expected - seen.visibility).clip(0)[wall & (np.abs(x) < 0.8)].mean())
