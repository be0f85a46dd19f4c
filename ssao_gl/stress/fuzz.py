"""Random cases. A case is its seed and number: what it draws does not depend on the method, so any method can replay it.

Cases of one block share what decides programs and textures (size, kind of depth, whether there are normals, filter), and
differ in all the rest: thousands a minute are drawn on a handful of frames.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from ..scene.projection import Size
from ..settings import limits
from .analytic_depth import cast, room, window_depth
from .case import Case
from .runner import CaseRunner
from .shot import Shot
from .specimen import Specimen

BLOCK = 16
"""Cases that follow each other on the same programs and textures."""
SIZES: tuple[Size, ...] = ((16, 12), (16, 12), (13, 11), (12, 16), (24, 1), (1, 24), (1, 1))
PREFIX = "random-"
HOSTILE = (np.nan, np.inf, -np.inf, 0.0, -0.0, -1.0, 1e-45, 1e-40, -1e-40, 1.2e-38, 1e-30, 1e-19, 1e10, 1e18, 9e18, 1e30, 3e38)


def random_case(seed: int, number: int) -> Case:
    """Return the case of that number; measuring it draws one shot, and returns 0 when it keeps what every picture promises."""

    def measure(lab: CaseRunner) -> float:
        lab.see(random_shot(seed, number, lab.subject))
        return 0.0

    promise = "a random picture keeps what every picture promises"
    return Case(f"{PREFIX}{number}", "random", promise, "0", 0.0, measure, asks=("orthographic", "infinite far"))


def planned(seed: int, numbers: range, subjects: list[Specimen]) -> Iterator[tuple[Case, Specimen]]:
    """Random cases, by blocks over the subjects in turn: over those that draw depth images, which these cases are."""
    subjects = [subject for subject in subjects if not subject.method.traits.needs_scene]
    for number in numbers if subjects else ():
        yield random_case(seed, number), subjects[number // BLOCK % len(subjects)]


def random_shot(seed: int, number: int, subject: Specimen) -> Shot:
    """Return what the case of that number draws."""
    shared, own = np.random.default_rng([seed, 0, number // BLOCK]), np.random.default_rng([seed, 1, number])
    size = SIZES[shared.integers(len(SIZES))]
    kind = "window" if shared.random() < 0.4 else "eye"
    blur = str(shared.choice(("none", "joint", "joint", "separable", "lecture")))
    with_normals = shared.random() < 0.4
    unit = 10 ** own.uniform(-6, 6)
    camera = random_camera(own, unit, size)
    depth = random_depth(own, camera, size, unit)
    if kind == "window":
        with np.errstate(all="ignore"):
            depth = window_depth(camera, depth)
    if own.random() < 0.5:
        depth = _hit(own, depth, HOSTILE)
    normals = random_normals(own, size) if with_normals else None
    with np.errstate(over="ignore"):
        depth = depth.astype(np.float32)
    radius: float | None = float(unit * 10 ** own.uniform(-4, 3)) if own.random() < 0.95 or kind == "window" else None
    changes = random_changes(own, subject)
    return Shot(camera, depth=depth, normals=normals, kind=kind, radius=radius, blur=blur, changes=changes)


def random_camera(random: np.random.Generator, unit: float, size: Size) -> Camera:
    """Any camera: perspective, reversed, infinite, off-centre, parallel, oblique; wide, narrow, stiff; either clip range."""
    near = unit * 10 ** random.uniform(-5, 0)
    far = near * 10 ** random.uniform(0.5, 11)
    kind = random.integers(6)
    if kind == 0:
        camera = Camera.orthographic(unit * 10 ** random.uniform(-3, 3), -near if random.random() < 0.3 else near, far)
    else:
        yfov = float(np.clip(math.pi * random.beta(0.6, 1.0), 1e-6, math.pi - 1e-4))
        camera = Camera.perspective(yfov, near, None if kind == 1 else far)
    m = np.array(camera.lens.matrix(size))
    if kind in (0, 3, 4):
        m[0, 2], m[1, 2] = random.normal(0, 1, 2) * 10 ** random.uniform(-2, 1)  # off-centre, or oblique rays
    if kind == 4:
        m[0], m[1] = m[0] * 10 ** random.uniform(-2, 2), -m[1]  # pixels that are not square, and upside down
    if kind == 5:
        m[:2, :2] = _turn(random.uniform(0, 2 * math.pi)) @ m[:2, :2]
    if random.random() < 0.4:  # reversed: the depth row runs from w to 0 (near to far) in the range 0..1
        m[2] = (m[3] - m[2]) / 2
        return Camera.from_matrix(m, clip="0..1")
    return Camera.from_matrix(m)


def random_depth(random: np.random.Generator, camera: Camera, size: Size, unit: float) -> NDArray[np.float64]:
    """(h, w) eye depth: shapes, steps, noise of one or of twenty orders of magnitude, near-constant planes, lone texels."""
    h, w = size[1], size[0]
    kind = random.integers(7)
    if kind <= 1:
        return cast(camera, size, *room(unit))
    if kind == 2:
        return np.asarray(unit * (1 + 5 * random.random((h, w))))
    if kind == 3:
        return np.asarray(unit * 10 ** random.uniform(-10, 10, (h, w)))
    if kind == 4:  # a plane whose texels differ by roundings
        return np.asarray(5 * unit * (1 + 2.0**-22 * random.integers(-2, 3, (h, w))))
    if kind == 5:
        return np.asarray(
            unit * np.where(np.add.outer(np.arange(h) // 3, np.arange(w) // 3) % 2, 1.0, 10 ** random.uniform(-2, 2))
        )
    return np.where(random.random((h, w)) < 0.05, 5 * unit, 0.0)


def random_normals(random: np.random.Generator, size: Size) -> NDArray[np.float32]:
    """(h, w, 3): of any direction and length, or on the axes; some of them unusable."""
    shape = (size[1], size[0], 3)
    kind = random.integers(3)
    if kind == 0:
        n = random.normal(size=shape) * 10 ** random.uniform(-8, 8, (*shape[:2], 1))
    elif kind == 1:
        n = random.integers(-1, 2, shape).astype(np.float64)
    else:
        n = np.broadcast_to(random.normal(size=3), shape)
    if random.random() < 0.4:
        n = _hit(random, n, HOSTILE)
    with np.errstate(over="ignore"):
        return n.astype(np.float32)


def random_changes(random: np.random.Generator, subject: Specimen) -> dict[str, Any]:
    """Return settings of the method that are real numbers, some of them at the ends of their ranges; they compile nothing
    anew."""
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(subject.method):  # type: ignore[arg-type]
        rule, roll = limits(field), random.random()
        ends = [end for end in (rule.low, rule.high) if end is not None]
        if isinstance(field.default, float) and field.name != "radius" and ends and roll < 0.2:
            changes[field.name] = float(ends[int(roll * 10) % len(ends)])
    return changes


def _hit(random: np.random.Generator, values: NDArray[Any], by: tuple[float, ...]) -> NDArray[np.float64]:
    """Return some of the values replaced by hostile ones."""
    where = random.random(values.shape) < 10 ** random.uniform(-2.5, 0)
    return np.where(where, random.choice(by, values.shape), values)


def _turn(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])
