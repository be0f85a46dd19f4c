"""Images of every size that a driver draws, and one that it does not."""

from __future__ import annotations

import numpy as np

from ...errors import ContextError
from ...scene.camera import Camera
from ..analytic_depth import cast, flat, room
from ..case import case
from ..outcomes import NotApplicable
from ..runner import CaseRunner
from ..shapes import lens
from ..shot import Shot, share

GROUP = "sizes"


@case("one-pixel", GROUP, "1 - darkest pixel", contract="plane", traps=(17, 22))
def one(lab: CaseRunner) -> float:
    """An image of one pixel, and of two by two on a plane, is open: no tap is left."""
    camera = lens()
    sizes = (1, 1), (2, 2)
    return max(lab.apply(cast(camera, s, flat((0, 0, -5), (0, 0.3, 1))), camera, blur="joint").darkest for s in sizes)


@case("any-size", GROUP, "1 - mean visibility", 1.0, traps=(17, 22, 23), why="finite is what is asked")
def ladder(lab: CaseRunner) -> float:
    """Odd, narrow and tiny images keep what every picture promises."""
    camera = lens()
    sizes = (1, 1), (1, 40), (40, 1), (2, 2), (3, 2), (5, 7), (33, 17)
    return max(1 - lab.apply(cast(camera, size, *room()), camera, blur="joint").mean for size in sizes)


@case(
    "largest-side",
    GROUP,
    "share of pixels off by over 1/255",
    0.02,
    contract="border",
    asks=("orthographic",),
    traps=(22, 40),
    why="16384 pixels along, a coordinate is exact to a thousandth of a pixel: taps on the very edge of a texel may round",
)
def largest(lab: CaseRunner) -> float:
    """A pattern across the largest image that the driver draws looks the same at both ends: no coordinate runs out of bits."""
    w = min(lab.renderer.ctx.max_size, 65536)
    worst = 0.0
    for size in ((w, 4), (4, w)):
        camera = Camera.orthographic(4.0 * size[1] / 64, 0.0, 40.0)  # a pixel is 1/16 unit
        y, x = np.mgrid[: size[1], : size[0]]
        depth = 5 + 0.25 * ((x // 8 + y // 8) % 2)
        seen = lab.apply(depth, camera, radius=0.5).visibility
        if size[0] == 4:
            seen = seen.T[:, ::-1]  # noise tiles are counted from the lower left
        worst = max(worst, share(seen[:, 64:128], seen[:, w - 128 : w - 64]))
    return worst


@case(
    "summed-areas",
    GROUP,
    "share of pixels off by over 1/255",
    0.0,
    traps=(43,),
    why="sums may wrap; their differences are exact",
)
def summed(lab: CaseRunner) -> float:
    """A pattern looks the same behind a million pixels at the near end of the range as behind few: sums of depth do not overflow."""
    if "depth_table" not in lab.subject.method.traits.inputs:
        raise NotApplicable("it does not sum depth over the image")
    corners = []
    for side in (160, 1120):
        y, x = np.mgrid[:side, :side]
        pattern = (y < 96) & (side - 1 - x < 96) & (((side - 1 - x) // 8 + y // 8) % 2 == 1)
        seen = lab.apply(5 + 0.25 * pattern, Camera.orthographic(4.0 * side / 64, 0.0, 40.0), radius=0.5).visibility
        corners.append(seen[16:80, -80:-16])  # the last that is summed up
    return share(*corners)


@case("too-large", GROUP, "1 when it is not refused", 0.0, traps=(22,), why="a refusal in words", once=True)
def too_large(lab: CaseRunner) -> float:
    """An image larger than the driver's largest texture is refused in one line, before anything is drawn."""
    if lab.subject.method.traits.needs_scene and lab.subject.method.traits.single_layer is None:
        raise NotApplicable("a depth image is no scene")
    side = lab.renderer.ctx.max_size + 1
    shot = Shot(lens(), depth=np.full((1, side), 5.0, np.float32))
    if not lab.subject.method.traits.draws_arrays:
        raise NotApplicable("a depth image has no scene, which the method needs")
    try:
        lab.renderer.apply(shot.depth, shot.camera, settings=lab.subject.settings(shot))  # type: ignore[arg-type]
    except ContextError as refusal:
        return float("draws at most" not in str(refusal))
    return 1.0


@case(
    "odd-size",
    GROUP,
    "difference of means",
    0.02,
    traps=(23,),
    why="another grid of pixels, and noise that does not fit the tile",
)
def odd(lab: CaseRunner) -> float:
    """An image one pixel narrower and lower is as dark on the whole."""
    camera = lens()
    w, h = lab.size
    means = [lab.apply(cast(camera, size, *room()), camera, blur="joint").mean for size in ((w, h), (w - 1, h - 1))]
    return abs(means[0] - means[1])
