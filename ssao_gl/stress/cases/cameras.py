"""Cameras of every kind, and in places where no camera should be."""

from __future__ import annotations

import math

import numpy as np

from ...scene.camera import Camera
from ...scene.model import Mesh, Scene
from ...scene.sample_scene import box, place, sphere
from ..analytic_depth import cast, flat, room
from ..case import case
from ..runner import CaseRunner
from ..shapes import corner, lens, plane
from ..shot import apart, share

GROUP = "cameras"
DARKEST = "1 - darkest pixel"
OFF = "share of pixels off by over 1/255"


@case("orthographic-plane", GROUP, DARKEST, contract="plane", asks=("orthographic",), traps=(34,))
def parallel_plane(lab: CaseRunner) -> float:
    """A tilted plane is open in a parallel projection."""
    return lab.render(plane(0.7), Camera.orthographic(4.0, 0.0, 40.0)).darkest


@case(
    "orthographic",
    GROUP,
    "mean difference over columns",
    0.01,
    contract="orthographic",
    asks=("orthographic",),
    traps=(34,),
    why="rays of sight still turn by up to 0.3 degrees",
)
def parallel(lab: CaseRunner) -> float:
    """A parallel projection looks as a narrow perspective from afar, but for a bias that grows with distance."""
    height, away = 5.0, 500.0
    narrow = Camera.perspective(2 * math.atan(height / 2 / (5 + away)), 1.0, 1000.0, place((1, 1, 1), (0, 0, away)))
    flat_on = Camera.orthographic(height, 0.0, 40.0)
    plain = {"bias": 0.0} if "distance" in lab.subject.units.get("bias", "") else {}
    seen = [lab.render(corner(), camera, changes=plain).visibility for camera in (narrow, flat_on)]
    return apart(*(one.mean(0) for one in seen))  # rows differ in noise alone


@case("oblique-parallel", GROUP, DARKEST, contract="plane", asks=("orthographic",), traps=(34, 35))
def oblique(lab: CaseRunner) -> float:
    """A plane is open in an oblique parallel projection, whose rays do not run along the axis."""
    m = np.array(Camera.orthographic(4.0, 0.0, 40.0).lens.matrix((64, 48)))
    m[0, 2], m[1, 2] = 0.3, -0.2
    return lab.render(plane(0.5), Camera.from_matrix(m)).darkest


@case(
    "off-centre",
    GROUP,
    OFF,
    0.01,
    contract="border",
    traps=(16, 35),
    why="away from the new border by the radius, edges may round",
)
def off_centre(lab: CaseRunner) -> float:
    """The left half of a wide image is what a lens shifted to the left sees, away from its new border."""
    w, h = lab.size
    m = np.array(lens().lens.matrix((2 * w, h)))
    left = m.copy()
    left[0] = 2 * m[0] + m[3]  # x in -1..0 stretched to -1..1
    whole = lab.render(corner(), lens(), size=(2 * w, h)).visibility[:, :w]
    part = lab.render(corner(), Camera.from_matrix(left), size=(w, h)).visibility
    inner = slice(0, w - 3 * w // 8)
    return share(whole[:, inner], part[:, inner])


@case("tiles", GROUP, OFF, 0.01, contract="border", traps=(16, 35), why="away from the seams by the radius, edges may round")
def tiles(lab: CaseRunner) -> float:
    """Four tiles of a print are the whole, away from their seams."""
    w, h = (side // 8 * 8 for side in lab.size)
    m = np.array(lens().lens.matrix((w, h)))
    whole = lab.render(corner(), lens(), size=(w, h), radius=0.3).visibility
    worst = 0.0
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
        t = m.copy()
        t[0], t[1] = 2 * m[0] + (1 - 2 * i) * m[3], 2 * m[1] + (1 - 2 * j) * m[3]
        part = lab.render(corner(), Camera.from_matrix(t), size=(w // 2, h // 2), radius=0.3).visibility
        rows = slice(0, h // 2) if j else slice(h // 2, h)
        expected = whole[rows, i * w // 2 : (i + 1) * w // 2]
        edge = (slice(h // 6, h // 2 - h // 6), slice(w // 6, w // 2 - w // 6))
        worst = max(worst, share(part[edge], expected[edge]))
    return worst


@case(
    "very-wide",
    GROUP,
    "difference of means",
    1.0,
    traps=(13, 18),
    why="finite at any angle; what is seen has no form to compare",
)
def wide(lab: CaseRunner) -> float:
    """Fields of view of 170 and 179.9 degrees keep what every picture promises."""
    for degrees in (170.0, 179.9):
        camera = Camera.perspective(math.radians(degrees), 0.1, 100.0)
        lab.apply(cast(camera, lab.size, *room()), camera)
        lab.render(corner(), camera)
    return 0.0


@case("very-narrow", GROUP, DARKEST, contract="plane", traps=(10,))
def narrow(lab: CaseRunner) -> float:
    """A tilted plane is open through a field of view of 0.1 degrees, where a pixel is 400 roundings of its depth wide."""
    camera = Camera.perspective(math.radians(0.1), 0.1, 100.0)
    height = 5 * math.radians(0.1)
    return lab.apply(cast(camera, lab.size, flat((0, 0, -5), (0, 0.5, 1))), camera, radius=height / 6).darkest


@case(
    "inside-a-mesh",
    GROUP,
    "1 - mean visibility",
    1.0,
    traps=(18, 19),
    why="back faces at the near plane have no right answer but a finite one",
)
def inside(lab: CaseRunner) -> float:
    """A camera inside a ball, inside a box and across a face keeps what every picture promises, with any radius."""
    solids = (
        Scene([Mesh(*sphere(16))]),
        Scene([Mesh(*box())]),
        Scene([Mesh(*box(), transforms=place((1, 1, 1), (0, 0, -1.0))[None])]),
    )
    eye = Camera.perspective(1.2, 1e-4, 10.0)
    return max(1 - lab.render(scene, eye, radius=radius).mean for scene in solids for radius in (0.1, 3.0))


@case("behind-the-camera", GROUP, "1 - mean visibility", 1.0, traps=(18, 20), why="finite is what is asked")
def behind(lab: CaseRunner) -> float:
    """A radius of a thousand times the distance, which reaches behind the eye, keeps what every picture promises."""
    camera = lens()
    depth = cast(camera, lab.size, *room())
    return max(1 - lab.apply(depth, camera, radius=radius).mean for radius in (50.0, 5000.0))
