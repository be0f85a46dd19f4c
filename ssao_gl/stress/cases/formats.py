"""Depth in every form that buffers hold it in: ranges, conventions, bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...scene.camera import Camera
from ..analytic_depth import as_half_floats, cast, room, window_depth
from ..case import case
from ..runner import CaseRunner
from ..shapes import corner, lens, scaled
from ..shot import apart, share

GROUP = "depth ranges and formats"
OFF = "share of pixels off by over 1/255"
MEAN = "mean difference"
FEW = 0.005
"""Share of pixels that may differ where two roundings of depth are compared: taps on the edge of the ball."""


def projection(near: float, far: float, *, reverse: bool = False, clip: str = "-1..1") -> NDArray[np.float64]:
    """A perspective projection like that of :func:`lens`, 4:3, reversed or not, infinite or not, for either clip range."""
    m = np.array(Camera.perspective(0.9).lens.matrix((4, 3)))
    at_near, at_far = (1.0, 0.0) if reverse else (0.0, 1.0)  # window depth
    if clip == "-1..1":
        at_near, at_far = 2 * at_near - 1, 2 * at_far - 1
    # clip z = a z_view + b with w = -z_view: at_near near = -a near + b and at_far far = -a far + b
    a, b = (-at_far, (at_near - at_far) * near) if np.isinf(far) else _through(near, far, at_near, at_far)
    m[2] = (0, 0, a, b)
    return m


def _through(near: float, far: float, at_near: float, at_far: float) -> tuple[float, float]:
    a = (at_near * near - at_far * far) / (far - near)
    return a, near * (at_near + a)


def by_window(lab: CaseRunner, m: NDArray[np.float64], clip: str = "-1..1", bits: int = 0, **options: object):  # type: ignore[no-untyped-def]
    """Visibilities (eye depth, window depth) of the room through a projection; ``bits`` of window depth, 0: 32-bit floats."""
    camera = Camera.from_matrix(m, clip=clip)  # type: ignore[arg-type]
    z = cast(camera, lab.size, *room())
    d = window_depth(camera, z, np.float64)
    eye = lab.apply(z, lens(), **options).visibility
    return eye, lab.apply(as_half_floats(d, bits) if bits else d, camera, kind="window", **options).visibility


def off(lab: CaseRunner, *args: object, **options: object) -> float:
    """Share of pixels where window depth gives another visibility than eye depth."""
    return share(*by_window(lab, *args, **options))  # type: ignore[arg-type]


@case("window-depth", GROUP, OFF, FEW, contract="far plane", why="taps on the edge of the ball")
def window(lab: CaseRunner) -> float:
    """Window depth of a common range, 0.1 to 40, gives what eye depth gives."""
    return off(lab, projection(0.1, 40.0))


@case("reversed-depth", GROUP, OFF, FEW, contract="far plane", traps=(2,), why="taps on the edge of the ball")
def backwards(lab: CaseRunner) -> float:
    """Reversed depth gives what eye depth gives, in clip ranges -1..1 and 0..1."""
    return max(off(lab, projection(0.1, 40.0, reverse=True, clip=clip), clip) for clip in ("-1..1", "0..1"))


@case(
    "infinite-far",
    GROUP,
    OFF,
    FEW,
    contract="far plane",
    asks=("infinite far",),
    traps=(3,),
    why="taps on the edge of the ball",
)
def endless(lab: CaseRunner) -> float:
    """An infinite far plane gives what a finite one gives, reversed or not; background at it is exactly open."""
    return max(off(lab, projection(0.1, np.inf, reverse=reverse, clip="0..1"), "0..1") for reverse in (False, True))


@case("depth-24-bit", GROUP, OFF, 2 * FEW, contract="far plane", traps=(1,), why="a step of depth is 1/5000 pixel at the wall")
def bits24(lab: CaseRunner) -> float:
    """Window depth of 24 bits gives what eye depth gives, over 0.1 to 40."""
    return off(lab, projection(0.1, 40.0), bits=24)


@case("depth-16-bit", GROUP, MEAN, 0.01, contract="far plane", traps=(1,), why="a step of depth is 1/100 pixel at the wall")
def bits16(lab: CaseRunner) -> float:
    """Window depth of 16 bits gives on average what eye depth gives, over 0.5 to 40."""
    return apart(*by_window(lab, projection(0.5, 40.0), bits=16))


@case("stiff-reversed", GROUP, OFF, FEW, contract="far plane", traps=(1,), why="taps on the edge of the ball")
def stiff_reversed(lab: CaseRunner) -> float:
    """Near 1e-4 and far 1e7 with reversed 32-bit depth give what eye depth gives."""
    return off(lab, projection(1e-4, 1e7, reverse=True, clip="0..1"), "0..1")


@case(
    "stiff-standard",
    GROUP,
    "1 - mean visibility",
    1.0,
    traps=(1,),
    why="a step of 24-bit depth is 0.02 here, and 6 at 100: no picture left to ask for",
)
def stiff(lab: CaseRunner) -> float:
    """Near 1e-4 and far 1e7 with depth of 16, 24 and 32 bits keep what every picture promises."""
    m = projection(1e-4, 1e7)
    return max(1 - float(by_window(lab, m, bits=bits)[1].mean()) for bits in (0, 16, 24))


@case("stiff-scene", GROUP, OFF, 0.002, contract="far plane", traps=(1, 2), why="edges may round to the next pixel")
def stiff_scene(lab: CaseRunner) -> float:
    """A corner drawn with near 1e-4 and far 1e7 looks the same at any of the distances 1 to 1e4."""
    stiff_lens = Camera.perspective(0.9, 1e-4, 1e7)
    plain = lab.render(corner(), lens()).visibility
    return max(
        share(plain, lab.render(scaled(corner(), s), stiff_lens, radius=0.8 * s).visibility) for s in (0.2, 1.0, 20.0, 2000.0)
    )


@case("far-plane", GROUP, MEAN, 1e-4, contract="far plane", traps=(4,), why="mean over the image")
def far(lab: CaseRunner) -> float:
    """Where the far plane lies, from 20 to 1e6, changes nothing, filtered neither."""
    seen = [lab.render(corner(), lens(zfar), blur="joint").visibility for zfar in (20.0, 200.0, 1e6)]
    return max(apart(seen[0], other) for other in seen[1:])
