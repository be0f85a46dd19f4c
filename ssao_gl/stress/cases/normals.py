"""Normals on the axes, of every direction, edge on, averted, and of few bits."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Mesh, Scene
from ...scene.sample_scene import place, sphere
from ..analytic_depth import cast, flat, room
from ..case import case
from ..outcomes import STEP
from ..runner import CaseRunner
from ..shapes import lens
from ..shot import Capture

GROUP = "normals"
ASKED = "1 - mean visibility"
ENOUGH = "finite is what is asked: normals contradict depth"


def on_room(lab: CaseRunner, normals: NDArray[np.float64], blur: str = "joint") -> Capture:
    """The room with these normals, whatever its depth says."""
    camera = lens()
    return lab.apply(cast(camera, lab.size, *room()), camera, normals=normals, blur=blur)


def spread(lab: CaseRunner, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(h, w, 3): the directions (n, 3) over the pixels, again and again."""
    w, h = lab.size
    return directions[np.arange(w * h) % len(directions)].reshape(h, w, 3)


@case("axis-normals", GROUP, ASKED, 1.0, traps=(12, 15), why=ENOUGH)
def axes(lab: CaseRunner) -> float:
    """Normals exactly on the axes and their 26 diagonals keep what every picture promises."""
    grid = np.array([v for v in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(v)])
    unit = grid / np.linalg.norm(grid, axis=1, keepdims=True)
    return max(1 - on_room(lab, spread(lab, n)).mean for n in (grid, unit))


@case("all-directions", GROUP, ASKED, 1.0, traps=(10, 11, 12, 14), why=ENOUGH)
def directions(lab: CaseRunner) -> float:
    """Random normals of all directions, of lengths from 1e-5 to 1e5, keep what every picture promises."""
    random = np.random.default_rng(3)
    w, h = lab.size
    n = random.normal(size=(h, w, 3))
    n *= 10 ** random.uniform(-5, 5, (h, w, 1)) / np.linalg.norm(n, axis=-1, keepdims=True)
    return 1 - on_room(lab, n).mean


@case("edge-on-normals", GROUP, ASKED, 1.0, traps=(11, 12, 14), why=ENOUGH)
def edge_on(lab: CaseRunner) -> float:
    """Normals at right angles to the view, round the whole circle and along every slice, keep what every picture promises."""
    angle = np.arange(360) * math.pi / 180
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], 1)
    return max(1 - on_room(lab, spread(lab, ring + [0, 0, lift])).mean for lift in (0.0, 1e-7, -1e-7, 1e-3))


@case("averted-normals", GROUP, ASKED, 1.0, traps=(14,), why=ENOUGH)
def averted(lab: CaseRunner) -> float:
    """Normals that face away from the viewer keep what every picture promises."""
    away = np.array([[0, 0, -1.0], [0, 1e-4, -1], [1e-9, 0, -1], [0.6, 0, -0.8]])
    return 1 - on_room(lab, spread(lab, away)).mean


@case("normal-length", GROUP, "share of pixels that differ at all", 0.0, traps=(7,), why="the same bytes")
def length(lab: CaseRunner) -> float:
    """The length of a caller's normals, a power of two from 2^-12 to 2^12, changes nothing."""
    n = spread(lab, np.array([[0.1, 0.2, 0.97], [-0.3, 0.1, 0.95]]))
    seen = [on_room(lab, n * 2.0**k).visibility for k in (0, -12, 12)]
    return max(float((seen[0] != one).mean()) for one in seen[1:])


@case(
    "8-bit-normals",
    GROUP,
    "1 - darkest pixel",
    2 * STEP,
    contract="plane",
    traps=(33,),
    why="8 bits a component turn a normal by up to 0.4 degrees",
)
def eight_bits(lab: CaseRunner) -> float:
    """A plane is open under normals that were stored in 8 bits a component."""
    worst = 0.0
    for tilt in (0.1, 0.3, 0.5):
        camera = lens()
        n = np.array([0, -math.sin(tilt), math.cos(tilt)])
        stored = np.round((n * 0.5 + 0.5) * 255) / 255 * 2 - 1
        depth = cast(camera, lab.size, flat((0, 0, -5), n))
        worst = max(worst, lab.apply(depth, camera, normals=np.broadcast_to(stored, (*depth.shape, 3))).darkest)
    return worst


@case(
    "smooth-normals",
    GROUP,
    "1 - mean visibility",
    0.3,
    contract="convex",
    traps=(14,),
    why="a coarse ball with smooth normals shades itself a little at its rim",
)
def smooth(lab: CaseRunner) -> float:
    """A ball of few triangles whose smooth normals face away at its rim does not turn black."""
    scene = Scene([Mesh(*sphere(8), transforms=place((1.5,) * 3, (0, 0, -5))[None])])
    return 1 - lab.render(scene, lens(), normals_of="shading").mean
