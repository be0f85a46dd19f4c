"""Measurements from which ``errors.json`` is made; ``ssao-gl planner fit`` runs them.

Every camera of the camera file beside each scene, at each size and with some radii, is traced (kept in the cache of traced
results) and drawn under every candidate: by the renderer, and by its depth alone. The weights are then fitted by
least squares of relative errors, none negative. Of every candidate the line says how far predictions of scenes that took
no part in the fit were off.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..io.atomic import why_unreadable
from ..io.cache import default_folder
from ..loaders.camera_files import load_cameras
from ..loaders.load import load_scene
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth import Tracing, Truth, trace
from .candidates import CANDIDATES, Candidate
from .error_model import SIGNS
from .features import ViewFeatures
from .plan import look
from .target_view import PlanTarget, of_arrays, of_scene

RADIUS_FACTORS = (0.5, 1.0, 2.0)
"""Of the camera file's."""
SPP = 128


@dataclass(frozen=True)
class ErrorSample:
    """What was measured of one view: its signs, and the RMSE of each candidate. ``layers``: that can be had."""

    scene: str
    layers: int
    radius_factor: float
    signs: ViewFeatures
    rmse: Mapping[str, float]


def file_views(paths: Sequence[Path]) -> Iterator[tuple[Scene, Camera]]:
    """Every camera of the files beside some scenes."""
    for path in paths:
        scene = load_scene(path)
        for camera in load_cameras(path.with_suffix(".cam.json")):
            yield scene, camera


def error_samples(
    renderer: Renderer, paths: Sequence[Path], sizes: Sequence[Size], kept: Collection[str]
) -> Iterator[tuple[str, list[ErrorSample]]]:
    """Yield the samples of every view, size and radius that is not ``kept``, with a label; other radii at the first size only."""
    for scene, camera in file_views(paths):
        for size in sizes:
            for factor in RADIUS_FACTORS if size == sizes[0] else (1.0,):
                label = f"{scene.name}:{camera.name} {size[0]}x{size[1]} radius x{factor:g}"
                if label not in kept:
                    yield label, measured(renderer, scene, camera, size, factor)


def load_samples(path: Path) -> dict[str, list[ErrorSample]]:
    """Read samples by label, none from a file that is not there yet. Raises FormatError for a damaged or foreign file."""
    if not path.exists():
        return {}
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected the rows that 'planner fit' keeps")
    try:
        rows = json.loads(path.read_text("utf-8"))
        return {
            label: [ErrorSample(**{**one, "signs": ViewFeatures(**one["signs"])}) for one in some]
            for label, some in rows.items()
        }
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        words = " ".join(str(error).split())[:120]
        raise FormatError(f"{path}: not the rows that 'planner fit' keeps ({words}); give --rows another name") from None


def measured(renderer: Renderer, scene: Scene, camera: Camera, size: Size, factor: float) -> list[ErrorSample]:
    """Return the rows of one view: as a scene, and as depth alone."""
    radius = factor * (camera.ao_radius or scene.default_radius())
    given = Settings().with_radius(radius)
    truth = trace(scene, camera, size, Tracing(radius=radius, spp=SPP), cache=default_folder())
    depth = renderer.render(scene, camera, size, given, aovs=("depth",)).depth
    subjects = of_scene(renderer, scene, camera, size, given, ("visibility",)), of_arrays(renderer, depth, camera, given)
    return [_row(subject, scene.name, factor, truth, depth) for subject in subjects]


def _row(subject: PlanTarget, name: str, factor: float, truth: Truth, depth: NDArray[Any]) -> ErrorSample:
    def settled(candidate: Candidate) -> Settings:
        return Settings(method=candidate.made(subject.radius))

    found = {
        c.name: foreground_rmse(subject.draw(settled(c), 1, ("visibility",), 0).visibility, truth, depth)
        for _, c in CANDIDATES.values()
        if c.layers <= subject.layers
    }
    return ErrorSample(name, subject.layers, factor, look(subject, settled)[0], found)


def foreground_rmse(visibility: NDArray[Any], truth: Truth, depth: NDArray[Any]) -> float:
    """Where both rays and the rasteriser see a surface, without the noise of the rays. 0 where there is none."""
    seen = (depth > 0) & truth.covered
    if not seen.any():
        return 0.0
    square = float(np.square(visibility[seen].astype(float) - truth.visibility[seen]).mean())
    return float(max(square - truth.noise**2, 0.0) ** 0.5)


def fit_weights(rows: Sequence[ErrorSample], name: str) -> NDArray[np.float64]:
    """Weights of the signs for a candidate."""
    from scipy.optimize import nnls

    values, found = _values(rows), np.array([row.rmse[name] for row in rows])
    weights: NDArray[np.float64] = nnls(values / np.maximum(found, 1e-4)[:, None], np.ones(len(found)))[0]
    return weights


def off(rows: Sequence[ErrorSample], name: str) -> NDArray[np.float64]:
    """How far off, relatively, the predictions of each scene are when it takes no part in the fit."""
    misses = []
    for scene in dict.fromkeys(row.scene for row in rows):
        weights = fit_weights([row for row in rows if row.scene != scene], name)
        left = [row for row in rows if row.scene == scene]
        misses += list(np.array([row.rmse[name] for row in left]) / np.maximum(_values(left) @ weights, 1e-4) - 1)
    return np.abs(misses)


def _values(rows: Sequence[ErrorSample]) -> NDArray[np.float64]:
    return np.array([[getattr(row.signs, sign) for sign in SIGNS[row.layers]] for row in rows])


def error_table(rows: Sequence[ErrorSample]) -> dict[str, Any]:
    """Return the content of ``errors.json``."""
    made: dict[str, Any] = {}
    for layers, signs in SIGNS.items():
        some = [row for row in rows if row.layers == layers]
        made[str(layers)] = {
            name: {
                "weights": dict(zip(signs, (round(float(w), 4) for w in fit_weights(some, name)), strict=True)),
                "mean_rmse": round(float(np.mean([row.rmse[name] for row in some if row.radius_factor == 1])), 4),
            }
            for name in some[0].rmse
        }
    return made


def held_out_lines(rows: Sequence[ErrorSample]) -> Iterator[str]:
    """Yield a line for each candidate: how far off its predictions are in scenes that took no part in the fit."""
    for layers in SIGNS:
        some = [row for row in rows if row.layers == layers]
        for name in some[0].rmse:
            misses = off(some, name)
            yield f"{layers} {name}: median {np.median(misses):.3f}, mean {misses.mean():.3f}, worst {misses.max():.2f}"
