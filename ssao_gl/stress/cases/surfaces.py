"""Shapes whose visibility is known: planes, convex bodies, depth steps and pits."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ...scene.camera import Camera
from ...scene.model import Mesh, Scene
from ...scene.sample_scene import place, sphere
from ..analytic_depth import ball_depth, cast, flat
from ..case import case
from ..outcomes import STEP, NotApplicable
from ..runner import CaseRunner
from ..shapes import corner, lens, plane, quad
from ..shot import Capture, share

GROUP = "known visibility"
DARKEST = "1 - darkest pixel"


@case("plane", GROUP, DARKEST, contract="plane", traps=(33,))
def straight(lab: CaseRunner) -> float:
    """A plane across the view is open, raw and filtered."""
    return max(lab.render(plane(), lens(), blur=blur).darkest for blur in ("none", "joint"))


@case("plane-80-degrees", GROUP, DARKEST, contract="plane", traps=(14, 24, 33))
def steep(lab: CaseRunner) -> float:
    """A plane that falls away at 80 degrees is open: no tap leaves the surface, no normal is rounded into it."""
    return max(lab.render(plane(sign * math.radians(80)), lens()).darkest for sign in (1, -1))


@case("plane-by-depth", GROUP, DARKEST, contract="plane", traps=(24, 33))
def steep_depth(lab: CaseRunner) -> float:
    """A plane that falls away at 80 degrees is open when its normals are rebuilt from depth."""
    tilt = math.radians(80)
    camera = lens()
    floor = flat((0, 0, -5), (0, -math.sin(tilt), math.cos(tilt)))
    return lab.apply(cast(camera, lab.size, floor), camera).darkest


@case("plane-very-wide", GROUP, DARKEST, contract="plane", traps=(13,))
def wide(lab: CaseRunner) -> float:
    """A plane is open to the edges of a field of view of 150 degrees, where slices lie far off the axis."""
    return lab.render(plane(0.3), Camera.perspective(math.radians(150), 0.1, 100.0)).darkest


@case("plane-turned", GROUP, DARKEST, contract="plane", traps=(13,))
def turned(lab: CaseRunner) -> float:
    """A plane is open when the camera turns aside by 60 degrees."""
    angles = math.radians(60), math.radians(-60)
    poses = [place((1, 1, 1), (0, 0, 0), angle) for angle in angles]
    return max(lab.render(plane(), lens(pose=pose)).darkest for pose in poses)


@case("corner-is-darker", GROUP, "0.1 - (walls - corner)", 0.0, why="an order is asked, no value")
def dark_corner(lab: CaseRunner) -> float:
    """A corner is darker than its walls by 0.1 at least."""
    columns = lab.render(corner(), lens(), blur="joint").visibility.mean(0)
    w = len(columns)
    middle, walls = columns[w // 2 - w // 16 : w // 2 + w // 16].mean(), np.r_[columns[: w // 8], columns[-w // 8 :]].mean()
    return float(0.1 - (walls - middle))


@case("convex-on-sky", GROUP, DARKEST, contract="convex", traps=(26, 27))
def convex(lab: CaseRunner) -> float:
    """A ball before nothing is open up to its rim, raw and filtered: sky neither occludes nor mixes in."""
    camera, center = lens(), np.array([0, 0, -5.0])
    depth = cast(camera, lab.size, ball_depth(center, 1.5))
    normals = (camera.view(lab.size).points(depth) - center) / 1.5
    return max(lab.apply(depth, camera, normals=normals, blur=blur).darkest for blur in ("none", "joint"))


@case(
    "convex-mesh",
    GROUP,
    "share of pixels off by over 1/255",
    0.01,
    contract="convex",
    traps=(26, 27),
    why="drivers move vertices to a grid of 1/16 pixel, which bends steep triangles at the rim",
)
def convex_mesh(lab: CaseRunner) -> float:
    """A ball of triangles before nothing is open."""
    scene = Scene([Mesh(*sphere(), transforms=place((1.5,) * 3, (0, 0, -5))[None])])
    return share(lab.render(scene, lens()).visibility, np.ones(1))


@case("depth-step", GROUP, DARKEST, contract="step", traps=(25,))
def step(lab: CaseRunner) -> float:
    """Plate and wall 300 radii apart do not touch each other: no depth in between is made up."""
    camera = Camera.perspective(0.02, 10.0, 500.0)
    near, far = quad((-20, 0, -150), (20, 0, 0), (0, 20, 0)), quad((0, 0, -300), (40, 0, 0), (0, 40, 0))
    return max(lab.render(Scene([near, far]), camera, radius=0.5, blur=blur).darkest for blur in ("none", "joint"))


@case(
    "closed-pit",
    GROUP,
    "visibility at the bottom",
    0.6,
    contract="pit",
    traps=(31, 39),
    why="far below open is asked, no value",
)
def pit(lab: CaseRunner) -> float:
    """The bottom of a narrow pit is dark, with walls of any thickness and every bit set: no zero becomes white."""
    seen = [pit_seen(lab, **changes).visibility[_bottom(lab.size)] for changes in ({}, {"thickness": 1000.0})]
    return max(float(one.mean()) for one in seen)


@case("power", GROUP, "growth of visibility with the exponent", STEP, traps=(44,))
def power(lab: CaseRunner) -> float:
    """The contrast exponent from 0.1 to 10 leaves a pit finite, and never brightens it."""
    if "power" not in lab.subject.units:
        raise NotApplicable("it has no exponent")
    seen = [pit_seen(lab, power=p).visibility for p in (0.1, 1.0, 10.0)]
    return max(float((b - a).max()) for a, b in pairwise(seen))


def pit_seen(lab: CaseRunner, **changes: float) -> Capture:
    """A square pit in a plane, half a radius deep, seen from straight above."""
    camera = lens()
    depth = cast(camera, lab.size, flat((0, 0, -5), (0, 0, 1)))
    depth[_bottom(lab.size)] += 0.5
    return lab.apply(depth, camera, radius=1.0, changes=changes)


def _bottom(size: tuple[int, int]) -> tuple[slice, slice]:
    w, h = size
    return slice(h // 2 - 2, h // 2 + 3), slice(w // 2 - 2, w // 2 + 3)
