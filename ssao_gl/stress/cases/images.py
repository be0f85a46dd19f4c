"""The image itself turned about: mirrored, rotated, shifted.

Noise, and which pixels an image of half the size keeps, are tied to the pixel grid and do not turn with the image. So means
over whole noise tiles are compared, each over four positions of the grid.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...scene.camera import Camera
from ..analytic_depth import cast, room
from ..case import case
from ..runner import CaseRunner

GROUP = "invariance of the image"
MEANS = "difference of means"
WHY = "noise does not turn with the image; means over whole tiles and four positions of the grid"
SQUARE = 64
REACH = 1.6
"""Radius: some 15 pixels, so that edges one pixel wide do not count too much."""

Image = NDArray[np.float64]
GRID = ((0, 0), (1, 2), (2, 1), (3, 3))


def lens(shift: tuple[int, int]) -> Image:
    """A square projection (4, 4), its image moved by some pixels."""
    m = np.array(Camera.perspective(0.9, 0.1, 40.0).lens.matrix((1, 1)))
    m[:2] += 2 / SQUARE * np.outer(shift, m[3])
    return m


def mean(lab: CaseRunner, turn: Image, turned: Callable[[Image], Image]) -> float:
    """Mean visibility of the room: its image turned, and the image plane of the camera by ``turn`` (2, 2)."""
    means = []
    for shift in GRID:
        m = lens(shift)
        z = cast(Camera.from_matrix(m), (SQUARE, SQUARE), *room())
        m[:2] = turn @ m[:2]
        means.append(lab.apply(turned(z), Camera.from_matrix(m), blur="joint", radius=REACH).mean)
    return float(np.mean(means))


def plain(lab: CaseRunner) -> float:
    """Of the image as it is."""
    return mean(lab, np.eye(2), lambda z: z)


@case("mirror", GROUP, MEANS, 1 / 255, contract="mirror", traps=(13, 23), why=WHY)
def mirror(lab: CaseRunner) -> float:
    """The mirror image, to the side and upside down, is as dark."""
    straight = plain(lab)
    aside = mean(lab, np.diag([-1.0, 1.0]), lambda z: z[:, ::-1])
    upside_down = mean(lab, np.diag([1.0, -1.0]), lambda z: z[::-1])
    return max(abs(straight - aside), abs(straight - upside_down))


@case("quarter-turn", GROUP, MEANS, 1 / 255, contract="rotation", traps=(13,), why=WHY)
def quarter(lab: CaseRunner) -> float:
    """The image turned by 90 degrees is as dark."""
    return abs(plain(lab) - mean(lab, np.array([[0.0, -1.0], [1.0, 0.0]]), np.rot90))


@case("grid-shift", GROUP, MEANS, 1 / 255, contract="border", traps=(27, 40), why="noise of another phase")
def shift(lab: CaseRunner) -> float:
    """The image moved by two pixels, across the noise, is as dark."""
    means = []
    for by in (0, 2):
        camera = Camera.from_matrix(lens((by, 0)))
        seen = lab.apply(cast(camera, (SQUARE, SQUARE), *room()), camera, blur="joint")
        inside = np.s_[8:-8, by : SQUARE - 2 + by]
        means.append(float(seen.visibility[inside][seen.surface[inside]].mean()))
    return abs(means[0] - means[1])
