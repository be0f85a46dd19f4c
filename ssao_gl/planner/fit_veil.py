"""Shares of slabs and veils fitted to rays, from which ``methods/veil_fits.json`` is made; ``ssao-gl planner veil`` runs it.

A filter is linear, and so is what is hidden in the shares: each view is drawn with a share of 1 for the slab, the near and the
far veil in turn, and ordinary least squares without intercept finds the shares of the three pictures that come nearest to what
rays find hidden. Views count alike. How well shares do on scenes they were not fitted to is told by leaving each scene out.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..io.cache import default_folder
from ..methods.bitmask import Bitmask
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth import Tracing, trace
from .measure import SPP, file_views

F64 = NDArray[np.float64]

SHARES = ("opacity", "near_veil", "veil")

FITTED: Mapping[str, str] = {"scale 4": "draft", "one layer": "medium", "two layers": "high"}
"""Kinds of settings that share a fit -> the preset that stands for them."""


@dataclass(frozen=True, slots=True)
class ShareSums:
    """What least squares needs of the pixels of a view: means of products.

    gram: (3, 3), of the pictures of unit shares. with_truth: (3,), of each with what rays find hidden. truth2: of that with
    itself. noise2: mean square of the truth's standard errors.
    """

    scene: str
    gram: F64
    with_truth: F64
    truth2: float
    noise2: float

    def rmse(self, shares: F64) -> float:
        """Return the RMSE of visibility under some shares, the truth's noise taken out."""
        square = float(shares @ self.gram @ shares - 2 * shares @ self.with_truth) + self.truth2 - self.noise2
        return math.sqrt(max(square, 0.0))


def fit_veils(paths: Sequence[Path], size: Size, renderer: Renderer, say: Any) -> dict[str, Any]:
    """Return the content of ``veil_fits.json``. ``say`` is told each view as it is done. Raises SceneError, SettingsError."""
    sums: dict[str, list[ShareSums]] = {kind: [] for kind in FITTED}
    for scene, camera in file_views(paths):
        for kind, name in FITTED.items():
            sums[kind].append(view_sums(renderer, scene, camera, size, _bitmask(name)))
        say(f"{scene.name}:{camera.name}")
    fits = {kind: _told(kind, some) for kind, some in sums.items()}
    record = {
        "scenes": list(dict.fromkeys(one.scene for one in next(iter(sums.values())))),
        "views": len(next(iter(sums.values()))),
        "size": list(size),
        "spp": SPP,
        "model": "least squares without intercept, views count alike; left_out: mean RMSE of views whose scene took no part",
    }
    return {"record": record, "fits": fits}


def view_sums(renderer: Renderer, scene: Scene, camera: Camera, size: Size, method: Bitmask) -> ShareSums:
    """Draw a view by each unit share and return the sums against rays."""
    radius = camera.ao_radius or scene.default_radius()
    truth = trace(scene, camera, size, Tracing(radius=radius, spp=SPP), cache=default_folder())
    hidden = []
    for one in SHARES:
        unit = dataclasses.replace(method, **dict.fromkeys(SHARES, 0.0) | {one: 1.0})  # type: ignore[arg-type]
        settings = Settings(method=unit).with_radius(radius)
        drawn = renderer.render(scene, camera, size, settings, aovs=("visibility", "depth"))
        hidden.append(1 - drawn.visibility)
    where = (drawn.depth > 0) & truth.covered
    x = np.stack([picture[where] for picture in hidden], 1).astype(np.float64)
    y = 1 - truth.visibility[where].astype(np.float64)
    noise2 = float(np.mean(truth.stderr[where].astype(np.float64) ** 2))
    return ShareSums(scene.name, x.T @ x / len(y), x.T @ y / len(y), float(np.mean(y**2)), noise2)


def fit_shares(some: Iterable[ShareSums]) -> F64:
    """Return the shares (3,) of least squares. A veil that shows nowhere gets none."""
    some = list(some)
    gram, with_truth = np.sum([one.gram for one in some], 0), np.sum([one.with_truth for one in some], 0)
    return np.asarray(np.linalg.lstsq(gram, with_truth, rcond=1e-9)[0]).clip(0, 1)


def _bitmask(name: str) -> Bitmask:
    """Return a preset of the method."""
    return Bitmask(**Bitmask.presets[name])


def _told(kind: str, some: Sequence[ShareSums]) -> dict[str, Any]:
    shares = fit_shares(some)
    left_out = [
        one.rmse(fit_shares(other for other in some if other.scene != one.scene)) for one in some
    ] if len({one.scene for one in some}) > 1 else []  # fmt: skip
    method = _bitmask(FITTED[kind])
    return {
        **{name: round(float(share), 3) for name, share in zip(SHARES, shares, strict=True)},
        "thickness": method.fitted.thickness,
        "preset": FITTED[kind],
        "rmse": round(float(np.mean([one.rmse(shares) for one in some])), 4),
        "left_out": round(float(np.mean(left_out)), 4) if left_out else None,
        "of_slabs_alone": round(float(np.mean([one.rmse(np.array([1.0, 0, 0])) for one in some])), 4),
    }
