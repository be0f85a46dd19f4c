"""What the rules of leaving out save in a view, and what they change: each on and off, in rounds in which all take turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..gl.timer import PassTime
from ..graph.names import BLOCK_OPEN
from ..io.images import flipped
from ..passes.culling import BLOCK
from ..pipeline.explain import rule_statuses
from ..pipeline.frame_setup import frame_setup
from ..pipeline.settings import CULLING_RULES, Settings, drawn_scale
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from .timing import interleaved

ALL_RULES = "all"
"""All rules at once, against none."""

FRAMES = len(CULLING_RULES) + 2
"""How many plans a renderer should keep (``Renderer(keep=FRAMES)``), so that rounds do not make textures anew."""

Mask = NDArray[np.bool_]
Times = NDArray[np.float64]
"""(rounds, 2): milliseconds of all passes after the G-buffer, by the wall's (or the GPU's) clock and of all threads."""


@dataclass(frozen=True, slots=True)
class RuleBenchmark:
    """A rule on and off in one view, or (``all``) all of them against none.

    on, off: milliseconds of all passes after the G-buffer, medians over the rounds, by the wall's (or the GPU's) clock;
    ``cpu_on`` and ``cpu_off`` of all threads of this process. ratio, cpu_ratio: medians of on / off of each round. pixels,
    taps: shares that are still to be shaded, of the image's pixels and of the taps of the method's own pass (without those of
    adaptive probes). difference: largest, of visibility and of the picture, in 1/255. bound: the most that it can be, in
    1/255; None where it is not known.
    """

    rule: str
    on: float
    off: float
    cpu_on: float
    cpu_off: float
    ratio: float
    cpu_ratio: float
    pixels: float
    taps: float
    difference: float
    bound: float | None

    def cells(self) -> tuple[str, ...]:
        """For a table with :data:`COLUMNS`."""
        bound = "not known" if self.bound is None else f"{self.bound:g}"
        times = (f"{self.on:.1f} / {self.off:.1f}", f"{self.cpu_on:.1f} / {self.cpu_off:.1f}")
        ratios = (f"{self.ratio:.2f}", f"{self.cpu_ratio:.2f}")
        return (self.rule, *times, *ratios, f"{self.pixels:.1%}", f"{self.taps:.1%}", f"{self.difference:g}", bound)


COLUMNS = ("rule", "ms on / off", "CPU ms on / off", "ratio", "by CPU", "pixels", "taps", "difference, 1/255", "bound")


def benchmark_rules(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings | None = None, *, rounds: int = 5
) -> list[RuleBenchmark]:
    """Draw a view under its rules, without each that is in force, and without any; the last record is of all together.

    ``size`` is (width, height) in pixels. Nothing is drawn, and nothing returned, where no rule is in force.
    """
    made = frame_setup(scene, camera, size, settings or Settings(), renderer.ctx.max_size)
    force = [rule for rule in rule_statuses(made, made.plan(("visibility",))) if not rule.why]
    if not force:
        return []
    on = made.settings
    variants = {"": on} | {rule.name: dataclasses.replace(on, keep=(*on.keep, rule.name)) for rule in force}
    variants[ALL_RULES] = dataclasses.replace(on, keep=tuple(CULLING_RULES))
    differences = _differences(renderer, scene, camera, size, variants)
    times = _times(renderer, scene, camera, size, variants, max(rounds, 1))
    covered, closed = shaded(renderer, scene, camera, size, on)
    left = {rule.name: covered if rule.name == "background" else closed for rule in force}
    left[ALL_RULES] = np.logical_and.reduce(list(left.values()))
    exact = {rule.name: rule.exact for rule in force} | {ALL_RULES: all(rule.exact for rule in force)}
    return [
        _saving(name, times[""], times[name], left[name], drawn_scale(on), differences[name], 0.0 if exact[name] else None)
        for name in left
    ]


def shaded(renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings) -> tuple[Mask, Mask]:
    """Return (what is not background, what lies in no open block), each (h, w), row 0 on top."""
    covered = renderer.render(scene, camera, size, settings, aovs=("depth",)).depth > 0
    blocks = renderer.resource(scene, camera, size, settings, BLOCK_OPEN)
    if blocks is None:
        return covered, np.ones_like(covered)
    inside = frame_setup(scene, camera, size, settings, renderer.ctx.max_size).region.image_rect
    (x, y), (w, h) = inside[:2] if inside else (0, 0), size
    closed = np.kron(blocks[..., 0] == 0, np.ones((BLOCK, BLOCK), np.bool_))
    return covered, flipped(closed[y : y + h, x : x + w])


def _differences(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, variants: Mapping[str, Settings]
) -> dict[str, float]:
    """Variant -> largest difference of visibility and of the picture to those of the first, 1/255."""
    pictures = [renderer.render(scene, camera, size, one) for one in variants.values()]
    return {
        name: max(_apart(pictures[0].image, picture.image), 255 * _apart(pictures[0].visibility, picture.visibility))
        for name, picture in zip(variants, pictures, strict=True)
    }


def _apart(one: NDArray[Any], other: NDArray[Any]) -> float:
    return float(np.abs(one.astype(np.float64) - other).max())


def _times(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, variants: Mapping[str, Settings], rounds: int
) -> dict[str, Times]:
    def draw(one: Settings) -> Sequence[PassTime]:
        return renderer.time(scene, camera, size, one, aovs=("visibility",))

    runs = interleaved({name: lambda one=one: draw(one) for name, one in variants.items()}, rounds)  # type: ignore[misc]
    return {name: np.array([_after_gbuffer(run) for run in every]) for name, every in runs.items()}


def _after_gbuffer(times: Sequence[PassTime]) -> tuple[float, float]:
    after = [one for one in times if one.role != "gbuffer"]
    return sum(one.ms for one in after), sum(one.cpu_ms for one in after)


def _saving(name: str, on: Times, off: Times, left: Mask, scale: int, difference: float, bound: float | None) -> RuleBenchmark:
    wall, cpu = (_medians(on[:, clock], off[:, clock]) for clock in (0, 1))
    return RuleBenchmark(
        rule=name,
        on=wall[0],
        off=wall[1],
        cpu_on=cpu[0],
        cpu_off=cpu[1],
        ratio=wall[2],
        cpu_ratio=cpu[2],
        pixels=float(left.mean()),
        taps=float(_texels(left, scale).mean()),
        difference=round(difference, 3),
        bound=bound,
    )


def _medians(on: Times, off: Times) -> tuple[float, float, float]:
    """Of on, of off, and of their ratio in each round."""
    return float(np.median(on)), float(np.median(off)), float(np.median(on / np.maximum(off, 1e-9)))


def _texels(mask: Mask, scale: int) -> Mask:
    """Of the smaller image: those that stand for any pixel of ``mask``; its grid begins at the lower left."""
    h, w = mask.shape
    padded = np.pad(mask[::-1], ((0, -h % scale), (0, -w % scale)))
    return np.asarray(padded.reshape(padded.shape[0] // scale, scale, -1, scale).any((1, 3)))
