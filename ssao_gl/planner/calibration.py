"""What a pixel costs on this driver: probe frames of a made-up scene, kept in a cache.

The scene is rough everywhere, so nothing of it is left out by content. It is drawn filling a small and a larger image, and
from afar, which tells fixed costs, those of an image's area and those of shading apart; under two candidates of each family,
which tell what taps cost.
"""

from __future__ import annotations

import hashlib
import json
import logging
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..gl.context import Context
from ..io.cache import read_cached, write_cached
from ..io.fingerprint import code_fingerprint
from ..pipeline.frame_setup import frame_setup
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.pose import look_at
from ..scene.projection import Size
from ..settings import as_table
from .candidates import FAMILIES, Family
from .choice import times
from .cost_model import DRAWN, CostRate, PassWork, PlannedFrame, Rates, fitted

if TYPE_CHECKING:
    from ..render.renderer import Renderer

VERSION = 2
"""Part of every key: raised whenever the same driver would be probed in another way."""

SOFTWARE_SIZES: tuple[Size, Size] = ((240, 135), (480, 270))
GPU_SIZES: tuple[Size, Size] = ((640, 360), (1920, 1080))
ROUNDS = 3

log = logging.getLogger("ssao_gl")


def clock(ctx: Context) -> str:
    """By which milliseconds are counted: see :data:`.choice.CLOCKS`."""
    return "cpu" if ctx.software else "gpu" if ctx.gpu_timer else "wall"


def key(ctx: Context) -> str:
    """Return the hash of all that decides what passes cost: the driver, our code and shaders, and what is probed."""
    probed = [[family.name, as_table(family.candidate(taps).made())] for family in FAMILIES for taps in family.probed]
    parts = [VERSION, ctx.provider, ctx.renderer, ctx.version, code_fingerprint(), probed]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]


def calibrated(renderer: Renderer, folder: Path) -> Mapping[str, Rates]:
    """Return the rates of every family, by its name, from the cache in ``folder`` or by probe frames."""
    path = folder / f"planner-{key(renderer.ctx)}.json"
    found = read_cached(path, _rates)
    if found is None:
        log.info("planner: probing %s, once", renderer.ctx.renderer)
        found = probe(renderer)
        write_cached(path, lambda temporary: _write(temporary, found))
    return found


def probe(renderer: Renderer) -> dict[str, Rates]:
    """Draw and time all probe frames. Passes that do the same in several families share a rate, which lessens its noise."""
    ctx = renderer.ctx
    small, large = SOFTWARE_SIZES if ctx.software else GPU_SIZES
    measured: dict[tuple[Any, ...], list[tuple[PassWork, float]]] = {}
    alike: dict[str, dict[str, tuple[Any, ...]]] = {family.name: {} for family in FAMILIES}
    probed = [(family, taps) for family in FAMILIES for taps in family.probed]
    scene, aovs = rough(), ("image",)
    for size, away in ((small, 1.0), (large, 1.0), (large, 3.0)):
        camera, radius = above(away), RADIUS * away
        covered = float((renderer.render(scene, camera, size, aovs=("depth",)).depth > 0).mean())
        for family, taps in probed:
            settings = Settings(method=family.candidate(taps).made(radius))
            ms = times(renderer.render(scene, camera, size, settings, aovs=aovs, timed=ROUNDS).report["passes"], clock(ctx))
            made = frame_setup(scene, camera, size, settings, ctx.max_size)
            plan = made.plan(aovs)
            scene_passes = {step.task.name for step in plan.steps if step.task.role in DRAWN}
            for task, one in PlannedFrame(plan, made.region, family.method, taps).works(covered).items():
                if task not in scene_passes:
                    alike[family.name][task] = _alike(task, family)
                    measured.setdefault(_alike(task, family), []).append((one, ms[task]))
    rates = {key: fitted(runs) for key, runs in measured.items()}
    return {name: {task: rates[key] for task, key in tasks.items()} for name, tasks in alike.items()}


def _alike(task: str, family: Family) -> tuple[Any, ...]:
    """Return the same for passes that do the same for a pixel."""
    scale, tile = family.fixed.get("scale"), family.fixed.get("tile")
    if task != family.method:
        return task, scale, tile
    return task, scale == 1, *sorted((key, value) for key, value in family.fixed.items() if key not in ("scale", "tile"))


CELLS: Size = (160, 90)
RADIUS = 4.0
"""Cells: 15 to 20 pixels of images that show it whole."""


def rough() -> Scene:
    """Return a field of random heights, one cell wide each, flat-shaded, about the origin in the plane of x and y."""
    w, h = CELLS
    x, y = np.meshgrid(np.arange(w + 1) - w / 2, np.arange(h + 1) - h / 2)
    z = 1.5 * np.random.default_rng(1).random(x.shape)
    corner = np.arange((w + 1) * (h + 1)).reshape(h + 1, w + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return Scene.from_arrays(np.stack([x, y, z], -1).reshape(-1, 3), triangles)


def above(away: float) -> Camera:
    """Return a camera over the field that shows four fifths of it, or, farther away, more than there is."""
    distance = 0.4 * CELLS[1] * away
    return Camera.perspective(np.pi / 2, 0.1 * distance, 10 * distance, look_at((0, 0, distance), (0, 0, 0), (0, 1, 0)))


def _write(path: Path, found: Mapping[str, Rates]) -> None:
    table = {name: {task: list(asdict(rate).values()) for task, rate in rates.items()} for name, rates in found.items()}
    path.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


def _rates(path: Path) -> dict[str, Rates]:
    """Return what :func:`_write` wrote. Raises for anything else."""
    table = json.loads(path.read_text("utf-8"))
    found: dict[str, Rates] = {
        name: {task: CostRate(*map(float, numbers)) for task, numbers in table[name].items()}
        for name in (family.name for family in FAMILIES)
    }
    parts = [part for rates in found.values() for rate in rates.values() for part in asdict(rate).values()]
    if not all(math.isfinite(part) and part >= 0 for part in parts):
        raise ValueError("rates must be numbers, not negative")
    return found
