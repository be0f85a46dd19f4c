"""Spheres: one alone, several at one place, without a size, far from the origin."""

from __future__ import annotations

import dataclasses

import numpy as np

from ...scene.model import Scene
from ...scene.spheres import Spheres
from ..case import case
from ..outcomes import STEP
from ..runner import CaseRunner
from ..shapes import lens, plane

GROUP = "spheres"
ALL = "share of pixels that differ at all"


def _heap() -> Spheres:
    """Thirty spheres on the plane before the camera."""
    random = np.random.default_rng(3)
    centers = random.uniform((-1.5, -1.2, -5), (1.5, 1.2, -4.2), (30, 3))
    return Spheres(centers.astype(np.float32), random.uniform(0.1, 0.5, 30).astype(np.float32))


def _scene(spheres: Spheres) -> Scene:
    return Scene(plane().meshes, spheres=[spheres])


@case("lone-sphere", GROUP, "1 where it is not seen", 0.0, traps=(28,), why="it is seen or not")
def lone(lab: CaseRunner) -> float:
    """Automatic camera and radius are made for a scene of one sphere, of any size anywhere: it fills a good part of the picture."""
    missed = 0.0
    for center, radius in (((0, 0, 0), 1.0), ((1e8, 0, 0), 1.0), ((0, 3e4, 0), 1e-3), ((0, 0, 0), 1e12)):
        scene = Scene(spheres=[Spheres.from_points([center], radius)])
        seen = lab.render(scene, scene.default_camera(lab.size), radius=None)
        missed = max(missed, float((seen.depth > 0).mean() < 0.1))
    return missed


@case("coincident-spheres", GROUP, ALL, 0.0, contract="coincident-spheres", why="the same bytes")
def coincident(lab: CaseRunner) -> float:
    """Spheres of the same place and size are as one of them."""
    heap = _heap()
    twice = dataclasses.replace(heap, centers=np.repeat(heap.centers, 3, 0), radii=np.repeat(heap.radii, 3))
    a, b = (lab.render(_scene(one), lens()).visibility for one in (heap, twice))
    return float((a != b).mean())


@case("spheres-without-size", GROUP, ALL, 0.0, why="the same bytes")
def without_size(lab: CaseRunner) -> float:
    """Spheres of radius 0 are not seen and block nothing."""
    heap = _heap()
    between = (heap.centers + np.roll(heap.centers, 1, 0)) / 2
    more = dataclasses.replace(heap, centers=np.concatenate([heap.centers, between]), radii=np.append(heap.radii, np.zeros(30)))
    a, b = (lab.render(_scene(one), lens()).visibility for one in (heap, more))
    return float((a != b).mean())


@case("far-spheres", GROUP, "share of pixels that differ by more than a step", 0.01, why="outlines round to either side")
def far(lab: CaseRunner) -> float:
    """A hundred million units from the origin a scene looks as it does there."""
    away = np.eye(4)
    away[:3, 3] = (2.0**27, -(2.0**26), 2.0**27)
    heap = _heap()
    there = dataclasses.replace(heap, transforms=away[None])
    floor = dataclasses.replace(plane().meshes[0], transforms=away[None])
    a = lab.render(_scene(heap), lens()).visibility
    b = lab.render(Scene([floor], spheres=[there]), lens(pose=away)).visibility
    return float((np.abs(a - b) > 1.5 * STEP).mean())
