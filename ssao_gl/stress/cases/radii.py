"""The radius, from nothing to more than the screen."""

from __future__ import annotations

from itertools import pairwise

from ..analytic_depth import cast, flat, room
from ..case import case
from ..outcomes import STEP, NotApplicable
from ..runner import CaseRunner
from ..shapes import corner, lens
from ..shot import Capture

GROUP = "radius"


def _a_length(lab: CaseRunner) -> None:
    if not lab.subject.radius_is_a_length:
        raise NotApplicable("its radius is not a length in the scene")


@case("no-radius", GROUP, "1 - darkest pixel", contract="radius", traps=(8, 21))
def none(lab: CaseRunner) -> float:
    """A radius of a thousandth of a pixel, and of 1e-9, darkens nothing."""
    _a_length(lab)
    return max(lab.render(corner(), lens(), radius=radius).darkest for radius in (1e-4, 1e-9))


@case("pixel-radius", GROUP, "growth of mean visibility", STEP, contract="monotone", traps=(21,))
def pixel(lab: CaseRunner) -> float:
    """From a quarter of a pixel to four pixels occlusion sets in without a jump back."""
    _a_length(lab)
    pixel_size = lens().view(lab.size).pixel * 5
    seen = [lab.render(corner(), lens(), radius=k * pixel_size).mean for k in (0.25, 0.5, 1, 2, 4)]
    return max(b - a for a, b in pairwise(seen))


@case("monotone-in-radius", GROUP, "growth of mean visibility", STEP, contract="monotone", traps=(20,))
def monotone(lab: CaseRunner) -> float:
    """A larger radius never makes a corner brighter on the whole."""
    _a_length(lab)
    seen = [lab.render(corner(), lens(), radius=radius).mean for radius in (0.2, 0.4, 0.8, 1.6)]
    return max(b - a for a, b in pairwise(seen))


@case("radius-over-the-screen", GROUP, "1 - mean visibility", 1.0, traps=(19, 20), why="finite is what is asked")
def over(lab: CaseRunner) -> float:
    """A radius of many screens keeps what every picture promises, on a wall that fills the view and a hair before the eye."""
    camera = lens()
    near = cast(camera, lab.size, flat((0, 0, -0.1001), (0.1, 0, 1)))
    shots: list[Capture] = [lab.apply(near, camera, radius=100.0, blur="joint")]
    shots.append(lab.apply(cast(camera, lab.size, *room()), camera, radius=1e4, blur="joint"))
    return max(1 - one.mean for one in shots)


@case("automatic-radius", GROUP, "1 - mean visibility", 1.0, traps=(7,), why="finite is what is asked")
def automatic(lab: CaseRunner) -> float:
    """Without a radius one is found, also for depth of one point, of one plane and of huge units."""
    camera = lens()
    depth = cast(camera, lab.size, *room())
    one = depth * 0
    one[3, 3] = 5
    shots = [depth, one, depth * 1e6, depth * 1e-6]
    return max(1 - lab.apply(z, camera, radius=None).mean for z in shots)
