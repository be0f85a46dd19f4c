"""What may change and what must not: units, place, driver, run."""

from __future__ import annotations

import numpy as np

from ...pipeline.settings import CULLING_RULES
from ...scene.camera import Camera
from ...scene.lens import Perspective
from ...scene.model import Mesh, Scene
from ...scene.sample_scene import box, default_scene, place
from ..analytic_depth import cast, room
from ..case import case
from ..outcomes import STEP, NotApplicable
from ..runner import CaseRunner
from ..shapes import corner, lens, moved, scaled
from ..shot import Shot, share

GROUP = "invariance of the scene"
OFF = "share of pixels off by over 1/255"
EDGES = "edges may round to the next pixel"


def spread(lab: CaseRunner) -> int:
    """Pixels of the image that change with each that is drawn: those of a smaller target show in their neighbours too."""
    return 4 if lab.subject.method.traits.scale > 1 else 1


@case("units", GROUP, OFF, 0.002, contract="scale", traps=(5, 6, 7), why=EDGES)
def units(lab: CaseRunner) -> float:
    """Scene and radius in units from 1e-6 to 1e6 give one picture."""
    scene = default_scene()
    home = scene.cameras[0]
    assert isinstance(home.lens, Perspective) and home.lens.zfar is not None
    worst, plain = 0.0, lab.render(scene, home).visibility
    for s in (1e-6, 1e-3, 1e3, 1e6):
        pose = home.pose.copy()
        pose[:3, 3] *= s
        camera = Camera.perspective(home.lens.yfov, home.lens.znear * s, home.lens.zfar * s, pose)
        worst = max(worst, share(plain, lab.render(scaled(scene, s), camera, radius=0.8 * s).visibility))
    return worst / spread(lab)


@case("units-of-depth", GROUP, OFF, 0.005, contract="scale", traps=(5, 6, 7, 9), why="taps on the edge of the ball")
def depth_units(lab: CaseRunner) -> float:
    """Depth and radius in units from 1e-6 to 1e6 give one picture, filtered too."""
    z = cast(lens(), lab.size, *room())
    plain = lab.apply(z, lens(), blur="joint").visibility
    shots = [lab.apply(z * s, lens(scale=s), radius=0.8 * s, blur="joint") for s in (1e-6, 1e-3, 1e3, 1e6)]
    return max(share(plain, one.visibility) for one in shots)


@case(
    "units-beyond-squares",
    GROUP,
    "1 - mean visibility",
    1.0,
    traps=(9, 42),
    why="squares of such lengths leave 32-bit floats; finite is what is asked",
)
def tiny_units(lab: CaseRunner) -> float:
    """Depth and radius in units of 1e-19 and of 1e17 keep what every picture promises."""
    z = cast(lens(), lab.size, *room())
    return max(1 - lab.apply(z * s, lens(scale=s), radius=0.8 * s, blur="joint").mean for s in (1e-19, 1e17))


@case("far-from-the-origin", GROUP, OFF, 0.002, contract="translation", why=EDGES)
def place_in_world(lab: CaseRunner) -> float:
    """Camera and scene moved together by 1e7 units give the same picture."""
    scene = default_scene()
    shift = np.eye(4)
    shift[:3, 3] = [1e7, -3e6, 2e7]
    far = moved(scene, shift)
    return share(*(lab.render(one, one.cameras[0]).visibility for one in (scene, far))) / spread(lab)


@case("turned-together", GROUP, OFF, 0.01, contract="rotation", why=EDGES)
def turned_together(lab: CaseRunner) -> float:
    """Camera and scene turned together give the same picture."""
    scene = default_scene()
    turn = place((1, 1, 1), (0, 0, 0), 1.0)
    turn = turn @ turn[[1, 2, 0, 3]][:, [1, 2, 0, 3]]  # about two axes
    away = moved(scene, turn)
    return share(*(lab.render(one, one.cameras[0]).visibility for one in (scene, away)))


@case("more-occluders", GROUP, "growth of mean visibility", STEP, contract="occluder")
def occluder(lab: CaseRunner) -> float:
    """A box put into a corner makes the rest of the corner no brighter on the whole."""
    bare = corner()
    cube = Mesh(*box(), transforms=place((0.25, 0.25, 0.25), (0, 0, -4.4), 0.5)[None])
    before, after = lab.render(bare, lens()), lab.render(Scene([*bare.meshes, cube]), lens())
    same = np.abs(before.depth - after.depth) < 1e-4
    return float((after.visibility - before.visibility)[same].mean())


@case("left-out", GROUP, "share of pixels that differ at all", 0.0, traps=(27,), why="the same bytes")
def left_out(lab: CaseRunner) -> float:
    """What is left out because the scene does not need it changes nothing: sky, and what nothing stands above."""
    walls = Mesh(*box(), transforms=place((4, 3, 6), (0, 0, -4))[None])
    cube = Mesh(*box(), transforms=place((0.7, 0.7, 0.7), (0.5, -2, -6), 0.5)[None])
    # Open blocks are looked for where taps are many, by methods that are exact there.
    many = {"scale": 1, "steps": 12} if lab.subject.method.traits.exactly_open else {}
    shots = [Shot(lens(), Scene([walls, cube]), blur=blur, changes=many) for blur in ("none", "joint")]
    shots += [Shot(lens(), depth=cast(lens(), lab.size, *room()), blur=blur) for blur in ("none", "joint")]
    pairs = [(lab.see(shot).visibility, lab.see(shot.but(keep=tuple(CULLING_RULES))).visibility) for shot in shots]
    return max(float((a != b).mean()) for a, b in pairs)


@case("same-bytes", GROUP, "share of pixels that differ at all", 0.0, why="the same bytes")
def again(lab: CaseRunner) -> float:
    """The same input gives the same bytes, also when other pictures were drawn in between."""
    z = cast(lens(), lab.size, *room())
    first = lab.apply(z, lens(), blur="joint").visibility
    lab.apply(z[::2, ::2].copy(), lens(), radius=0.3)
    lab.render(corner(), lens(), blur="joint")
    return float((first != lab.apply(z, lens(), blur="joint").visibility).mean())


@case("provider", GROUP, OFF, 0.005, why="drivers round taps on texel borders differently")
def provider(lab: CaseRunner) -> float:
    """This driver draws what the first one that opens draws."""
    first = lab.first()
    if first.ctx.provider == lab.renderer.ctx.provider:
        raise NotApplicable("this is the first provider that opens, with which others are compared")
    lab.apply(cast(lens(), lab.size, *room()), lens(), blur="joint")
    shot = lab.shots[-1]
    return share(lab.see(shot).visibility, lab.see(shot, first).visibility)
