"""The image itself turned about: mirrored, rotated, shifted. Noise is tied to the pixel grid, so means are compared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...camera import Camera
from ..case import case
from ..fields import cast, room
from ..lab import Lab
from ..shot import Seen

GROUP = "invariance of the image"
MEANS = "difference of means"
WHY = "the noise tile does not turn with the image; means over whole tiles are compared"
SQUARE = 64


def shot(lab: Lab, turn: NDArray[np.float64], image: NDArray[np.float64]) -> Seen:
    """A depth image under a square camera whose image plane was turned by ``turn`` (2, 2)."""
    m = np.array(Camera.perspective(0.9, 0.1, 40.0).lens.matrix((1, 1)))
    m[:2, :2] = turn @ m[:2, :2]
    return lab.apply(image, Camera.from_matrix(m), blur="joint")


def square(lab: Lab) -> NDArray[np.float64]:
    """The room as a square image, its side a multiple of the noise tiles."""
    side = min(SQUARE, lab.size[0] // 8 * 8)
    return cast(Camera.perspective(0.9, 0.1, 40.0), (side, side), *room())


@case("mirror", GROUP, MEANS, 1 / 255, contract="mirror", traps=(13, 23), why=WHY)
def mirror(lab: Lab) -> float:
    """The mirror image is as dark."""
    z = square(lab)
    plain = shot(lab, np.eye(2), z).mean
    return max(
        abs(plain - shot(lab, np.diag(flip), z[step]).mean)
        for flip, step in (((-1.0, 1.0), np.s_[:, ::-1]), ((1.0, -1.0), np.s_[::-1]))
    )


@case("quarter-turn", GROUP, MEANS, 1 / 255, contract="rotation", traps=(13,), why=WHY)
def quarter(lab: Lab) -> float:
    """The image turned by 90 degrees is as dark."""
    z = square(lab)
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    return abs(shot(lab, np.eye(2), z).mean - shot(lab, turn, np.rot90(z)).mean)


@case("grid-shift", GROUP, MEANS, 1 / 255, contract="border", traps=(27, 40), why=WHY)
def shift(lab: Lab) -> float:
    """The image moved by a pixel, across the noise, is as dark."""
    side = min(SQUARE, lab.size[0] // 8 * 8)
    m = np.array(Camera.perspective(0.9, 0.1, 40.0).lens.matrix((1, 1)))
    moved = m.copy()
    moved[0] += 2 / side * m[3]
    means = []
    for one, columns in ((m, slice(0, side - 1)), (moved, slice(1, side))):
        camera = Camera.from_matrix(one)
        seen = lab.apply(cast(camera, (side, side), *room()), camera, blur="joint")
        inside = np.s_[8:-8, columns]
        means.append(float(seen.visibility[inside][seen.surface[inside]].mean()))
    return abs(means[0] - means[1])
