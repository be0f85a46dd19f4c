"""Visibility of places from the sides that count, kept on disk while it is traced."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..io.fingerprint import add_arrays, add_mesh
from ..scene.model import Scene
from ..settings import as_table
from ..truth.batches import Places, TraceProgress, gather_sums
from ..truth.store import Store, store
from .elements import Elements, light_by_elements
from .settings import Baking

VERSION = 2
"""Part of every key of the cache: raised whenever the same input gives other numbers."""


class BakePlaces(Places, Protocol):
    """Places on surfaces that may be seen from behind."""

    @property
    def double_sided(self) -> NDArray[np.bool_]:
        """(n,) whether the back is seen, too."""

    def backs(self, which: NDArray[np.bool_]) -> BakePlaces:
        """Return some of the places, from behind."""

    def content(self) -> Iterator[NDArray[Any]]:
        """Yield all that decides the points, for a hash."""


@dataclass(frozen=True, eq=False)
class TracedPlaces:
    """Visibility (n,) of places, how many rays it took (0 by elements), and seconds; ``cached``: none of them was traced now.

    indirect: (n, 3) linear light that arrives from other surfaces under a sky of 1, or (n, 0) where nobody asked.
    """

    visibility: NDArray[np.float64]
    indirect: NDArray[np.float64]
    rays: int
    seconds: float
    cached: bool


def trace_places(
    scene: Scene,
    places: BakePlaces,
    settings: Baking,
    cache: Path | None,
    progress: TraceProgress | None,
    disks: Elements | None = None,
) -> TracedPlaces:
    """Trace places on the sides that count, and take the more open one of two. ``disks``: of the scene, where these measure in the place of rays."""
    front = _one_side(scene, places, settings, cache, progress, disks)
    which = places.double_sided if settings.sides == "auto" else np.full(len(places), settings.sides == "both")
    if not which.any():
        return front
    back = _one_side(scene, places.backs(which), settings, cache, progress, disks)
    visibility, indirect = front.visibility.copy(), front.indirect.copy()
    open_behind = back.visibility > visibility[which]
    better = np.flatnonzero(which)[open_behind]
    visibility[better], indirect[better] = back.visibility[open_behind], back.indirect[open_behind]
    return TracedPlaces(
        visibility, indirect, front.rays + back.rays, front.seconds + back.seconds, front.cached and back.cached
    )


def _one_side(
    scene: Scene,
    places: BakePlaces,
    settings: Baking,
    cache: Path | None,
    progress: TraceProgress | None,
    disks: Elements | None = None,
) -> TracedPlaces:
    rays = len(places) * settings.batches[0] * settings.batches[1] if disks is None else 0
    kept: Store | None = None
    if cache is not None:
        kept = store(cache, _key(scene, places, settings), "bake")
        done = kept.result()
        if done is not None:
            return TracedPlaces(done["light"][:, 0], done["light"][:, 1:], rays, float(done["seconds"]), True)
    if disks is not None:
        light, seconds = light_by_elements(places, disks)
    else:
        sums = gather_sums(places, settings, kept=kept, progress=progress)
        light, seconds = np.clip(sums.estimate()[0], 0, 1)[:, None], sums.seconds
    if kept is not None:
        kept.finish({"light": light, "seconds": seconds})
    return TracedPlaces(light[:, 0], light[:, 1:], rays, seconds, False)


def _key(scene: Scene, places: BakePlaces, settings: Baking) -> str:
    """Return the hash of all that decides the numbers."""
    digest = hashlib.sha256(json.dumps([VERSION, as_table(settings)], sort_keys=True).encode())
    for mesh in scene.meshes:
        add_mesh(digest, mesh, normals=True, colors=settings.indirect)
    add_arrays(digest, places.content())
    return digest.hexdigest()[:32]
