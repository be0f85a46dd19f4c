"""Depth and normals of a caller's that hold anything that 32 bits can."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..analytic_depth import cast, flat, room, window_depth
from ..case import case
from ..runner import CaseRunner
from ..shapes import lens
from ..shot import share

GROUP = "hostile texels"
EXACT = "share of pixels that differ at all"
DARKEST = "1 - darkest pixel"

DENORMAL = float(np.float32(1e-40))
UNUSABLE = (np.nan, np.inf, -np.inf, -1.0, -0.0, -DENORMAL, DENORMAL, 1e-45, 1e-30, 1e30, float(np.finfo(np.float32).max))
"""What cannot be a distance, and distances whose squares no float holds: read as background."""
EXTREME = (2e-19, 1e-10, 1e10, 9e18)
"""The smallest and the largest distances that are taken, and some between."""


def sprinkled(
    depth: NDArray[np.float64], values: tuple[float, ...], share_of: float = 0.2, seed: int = 1
) -> NDArray[np.float32]:
    """``depth`` with a share of its texels replaced by one of ``values`` each."""
    random = np.random.default_rng(seed)
    hit = random.random(depth.shape) < share_of
    with np.errstate(over="ignore"):
        return np.where(hit, random.choice(values, depth.shape), depth).astype(np.float32)


@case("unusable-depth", GROUP, EXACT, 0.0, traps=(3, 28, 42), why="the same bytes")
def unusable(lab: CaseRunner) -> float:
    """NaN, infinite, negative, denormal and overflowing depth is background: the same bytes as with zeros there."""
    camera = lens()
    z = cast(camera, lab.size, *room())
    dirty = sprinkled(z, UNUSABLE)
    clean = np.where((dirty > 1e-18) & (dirty < 1e18), dirty, 0)
    seen = [[lab.apply(d, camera, blur=blur).visibility for d in (dirty, clean)] for blur in ("none", "joint")]
    return max(float((a != b).mean()) for a, b in seen)


@case("unusable-window-depth", GROUP, EXACT, 0.0, contract="", traps=(3, 28), why="the same bytes")
def unusable_window(lab: CaseRunner) -> float:
    """NaN and infinity in window depth are background: the same bytes as with the far plane there."""
    camera = lens()
    d = window_depth(camera, cast(camera, lab.size, *room()))
    dirty = sprinkled(d.astype(np.float64), (np.nan, np.inf, -np.inf))
    clean = np.where(np.isfinite(dirty), dirty, 1)
    a, b = (lab.apply(one, camera, kind="window", blur="joint").visibility for one in (dirty, clean))
    return float((a != b).mean())


@case("window-depth-out-of-range", GROUP, "1 - mean visibility", 1.0, traps=(2, 3, 28), why="finite is what is asked")
def beyond(lab: CaseRunner) -> float:
    """Window depth below 0, above 1 and at the poles of the projection keeps what every picture promises."""
    camera = lens()
    d = window_depth(camera, cast(camera, lab.size, *room())).astype(np.float64)
    pole = 0.5 + 0.5 * (40.1 / 39.9)  # where depth itself becomes infinite
    dirty = sprinkled(d, (-1.0, 1.5, 2.0, -1e30, 1e30, pole, np.nextafter(1, 0), np.nextafter(1, 2), DENORMAL))
    return 1 - lab.apply(dirty, camera, kind="window", blur="joint").mean


@case("extreme-depth", GROUP, "1 - mean visibility", 1.0, traps=(9, 28, 42), why="finite is what is asked")
def extreme(lab: CaseRunner) -> float:
    """Depths from 2e-19 to 9e18 beside each other keep what every picture promises."""
    camera = lens()
    z = cast(camera, lab.size, *room())
    shots = [sprinkled(z, EXTREME), np.full(z.shape, EXTREME[0]), np.full(z.shape, EXTREME[-1]), sprinkled(z, EXTREME, 1.0)]
    return max(1 - lab.apply(depth, camera, radius=radius, blur="joint").mean for depth in shots for radius in (1e-9, 0.8, 1e9))


@case("no-surface", GROUP, "share of pixels that are not open", 0.0, traps=(3, 26), why="exactly open")
def nothing(lab: CaseRunner) -> float:
    """An image of background alone is open everywhere, whichever way background is written."""
    camera = lens()
    w, h = lab.size
    ways = [("eye", v) for v in (0.0, np.nan, np.inf)] + [("window", 1.0)]
    seen = [lab.apply(np.full((h, w), v), camera, kind=kind, blur="joint").visibility for kind, v in ways]
    return max(float((one != 1).mean()) for one in seen)


@case("lone-texels", GROUP, DARKEST, contract="lone texel", traps=(17, 27))
def lone(lab: CaseRunner) -> float:
    """Single texels of a surface in a sea of background are open: nothing is there to occlude them."""
    camera = lens()
    w, h = lab.size
    depth = np.zeros((h, w))
    depth[2::16, 2::16] = 5.0
    return max(lab.apply(depth, camera, blur=blur, radius=0.4).darkest for blur in ("none", "joint"))


@case("unusable-normals", GROUP, EXACT, 0.0, traps=(8, 28), why="the same bytes")
def bad_normals(lab: CaseRunner) -> float:
    """NaN, infinite and zero normals are read as facing the viewer: the same bytes as with (0, 0, 1) there."""
    camera = lens()
    depth = cast(camera, lab.size, flat((0, 0, -5), (0, 0.3, 1)))
    w, h = lab.size
    facing = np.zeros((h, w, 3))
    facing[..., 2] = 1
    random = np.random.default_rng(2)
    bad = np.array([[np.nan] * 3, [np.inf, 0, 0], [0, 0, 0], [np.nan, 0, 1], [0, -np.inf, np.inf], [1e-30, 0, 0], [1e30, 0, 0]])
    dirty = bad[random.integers(0, len(bad), (h, w))]
    a, b = (lab.apply(depth, camera, normals=n, blur="joint").visibility for n in (dirty, facing))
    return float((a != b).mean())


@case(
    "one-texel-off",
    GROUP,
    "share of pixels that changed",
    0.25,
    contract="local",
    traps=(25,),
    why="the square of the radius, 24 of 64 pixels wide",
)
def local(lab: CaseRunner) -> float:
    """A single wrong texel changes pixels within the radius of it, and no others."""
    camera = lens()
    depth = cast(camera, lab.size, flat((0, 0, -5), (0, 0.3, 1)))
    spoilt = depth.copy()
    spoilt[lab.size[1] // 2, lab.size[0] // 2] *= 0.98
    return share(lab.apply(depth, camera, radius=0.5).visibility, lab.apply(spoilt, camera, radius=0.5).visibility)
