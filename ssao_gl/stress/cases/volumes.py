"""Volumes: iso-surfaces that are known on paper, data that hold next to nothing, transfer functions at their ends."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import InputWarning, SceneError
from ...scene.model import Scene
from ...scene.pose import look_at
from ...scene.transfer import Transfer, TransferPoint
from ...scene.volume import Volume
from .. import shapes
from ..case import case
from ..runner import CaseRunner

GROUP = "volumes"
STEEP, CLEAR = Transfer([TransferPoint(0.5, 0), TransferPoint(0.5, 1)]), Transfer([TransferPoint(0, 0)])


def _half_space(tilt: float, voxel: float = 8.0) -> Scene:
    """A plane 5 units before the camera, tilted about x, as distances in voxels far larger than a pixel's footprint."""
    affine = np.diag([voxel, voxel, voxel, 1.0])
    affine[:3, 3] = -4 * voxel
    index = np.stack(np.meshgrid(*[np.arange(9)] * 3, indexing="ij"), -1)
    normal = np.array([0, -np.sin(tilt), np.cos(tilt)])
    return Scene(volumes=[Volume(([0, 0, -5] - (index @ affine[:3, :3].T + affine[:3, 3])) @ normal, affine, iso=0.0)])


def _ball(place: ArrayLike, radius: float, n: int = 24) -> Volume:
    h = 2.6 * radius / (n - 1)
    affine = np.diag([h, h, h, 1.0])
    affine[:3, 3] = np.asarray(place) - 1.3 * radius
    index = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1) * h - 1.3 * radius
    return Volume(radius - np.linalg.norm(index, axis=-1), affine, iso=0.0)


@case("volume-plane", GROUP, "1 - darkest pixel", contract="plane", traps=(14, 33))
def plane(lab: CaseRunner) -> float:
    """A plane that is the iso-surface of a volume is open, across the view and tilted."""
    return max(
        lab.render(_half_space(tilt), shapes.lens(), blur=blur).darkest for tilt in (0.0, 0.7) for blur in ("none", "joint")
    )


@case(
    "volume-ball", GROUP, "error of depth in units of its bound", 1.02, once=True, why="the bound is that of the field itself"
)
def ball(lab: CaseRunner) -> float:
    """A ball of distances is as deep as a ball within h^2 / 4 R, h its voxels, near the origin, far from it, tiny and huge."""
    worst = 0.0
    for place, radius in (((0, 0, -5), 1.0), ((1e6, -2e6, 1e6), 1.0), ((0, 0, 0), 1e-9), ((0, 0, 0), 1e12)):
        middle = np.asarray(place, np.float64)
        volume, camera = (
            _ball(middle, radius),
            shapes.lens(8.0, radius, look_at(middle + radius * np.array([0, 0, 4.0]), middle, (0, 1, 0))),
        )
        seen = lab.render(Scene(volumes=[volume]), camera, radius=radius / 3)
        points = camera.view(lab.size).points(seen.depth.astype(np.float64) / radius)[seen.surface] + [0, 0, 4]
        if not len(points):
            return np.inf
        worst = max(worst, float(np.abs(np.linalg.norm(points, axis=1) - 1).max() / ((volume.voxel / radius) ** 2 / 4)))
    return worst


@case("volume-extremes", GROUP, "inputs that are neither drawn nor refused in a line", 0.0, once=True, why="a count")
def extremes(lab: CaseRunner) -> float:
    """Flat and one-voxel volumes, constant data, levels at the ends, singular axes and voxels that are no numbers are drawn, or refused in a line."""
    lost = 0
    for array, options in _odd():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", InputWarning)
                scene = Scene(volumes=[Volume(array, **options)])
            lab.render(scene, scene.default_camera(lab.size), radius=None)
        except SceneError as error:
            lost += "\n" in str(error)
    return float(lost)


def _odd() -> Iterator[tuple[NDArray[Any], Mapping[str, Any]]]:
    """Yield voxels, and how they are seen."""
    ramp = np.arange(60.0).reshape(3, 4, 5)
    for shape in ((60, 1, 1), (1, 60, 1), (1, 1, 60), (12, 5, 1)):
        yield ramp.reshape(shape), {"iso": 30.0}
    for array in (np.full((1, 1, 1), 3.0), np.zeros((4, 4, 4)), np.full((2, 3, 4), np.nan), np.zeros((0, 3, 3)), np.zeros(5)):
        yield array, {"iso": 0.5}
        yield array, {"transfer": STEEP}
    for level in (-1.0, 0.0, 1e-300, 1.0, 58.999, 59.0, 60.0, np.nan, np.inf):
        yield ramp, {"iso": level}
    for affine in (
        np.diag([1, 1, 0, 1.0]),
        np.diag([1, 1, 1e-9, 1.0]),
        np.diag([1, -1, 3, 1.0]),
        np.diag([1e-30, 1e-30, 1e-30, 1]),
        np.eye(3),
    ):
        yield ramp, {"iso": 30.0, "affine": affine}
    holes = ramp.copy()
    holes[1, 0], holes[1, 1] = np.nan, np.inf
    yield holes, {"iso": 30.0}
    for values in (ramp * 1e300, ramp * 1e-300, ramp + 1e15, ramp.astype(np.uint8), ramp > 30, ramp.astype(np.float16)):
        yield values, {}
    for transfer in (
        STEEP,
        CLEAR,
        Transfer([TransferPoint(30, 1)]),
        Transfer([TransferPoint(0, 1e-6), TransferPoint(59, 1)], unit=1e-6, step=4),
    ):
        yield ramp, {"transfer": transfer}


@case("volume-opacity", GROUP, "share of pixels that differ from background", 0.0, once=True, why="nothing is asked to be seen")
def transparent(lab: CaseRunner) -> float:
    """Volumes without opacity, and those that take less than half of the light, leave what lies behind them as it is."""
    wall, affine = shapes.plane(0.2), np.eye(4)
    affine[:3, 3] = -0.5, -0.5, -4
    thin = Transfer([TransferPoint(0, 0.1)])
    volumes = [Volume(np.arange(8.0).reshape(2, 2, 2), affine, transfer=transfer) for transfer in (CLEAR, thin)]
    bare = lab.render(wall, shapes.lens()).depth
    return max(float((lab.render(Scene(wall.meshes, volumes=[one]), shapes.lens()).depth != bare).mean()) for one in volumes)
