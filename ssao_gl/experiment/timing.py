"""How long passes take, measured in rounds in which all take turns: what else the machine does slows all alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..gl.timer import PassTime
from .statistics import quartiles

GROUPS = ("gbuffer", "method", "filter", "other")
"""What passes are counted under; ``other`` is preparation, a second layer, upsampling. ``total`` is all after the G-buffer."""

TimedDraw = Callable[[], Sequence[PassTime]]


def interleaved(
    draws: Mapping[str, TimedDraw],
    rounds: int,
    *,
    most: Mapping[str, int | None] | None = None,
    tick: Callable[[], None] = lambda: None,
) -> dict[str, list[Any]]:
    """Return name -> the pass times of each round. A round before the first, not in the result, compiles and warms up.

    ``most``: rounds after which a name sits out.
    """
    runs: dict[str, list[Any]] = {name: [] for name in draws}
    order = list(draws)
    for number in range(rounds + 1):
        for name in (
            order[number % max(len(order), 1) :] + order[: number % max(len(order), 1)]
        ):  # another one begins each round
            enough = (most or {}).get(name)
            if enough is None or number <= enough:
                times = draws[name]()
                if number:
                    runs[name].append(times)
            tick()
    return runs


GROUP_OF = {"gbuffer": "gbuffer", "occlusion": "method", "denoise": "filter"}
"""Role of a pass -> its group; of all others: ``other``."""


def group(one: PassTime) -> str:
    """Return the group of a pass."""
    return GROUP_OF.get(one.role, "other")


def summary(runs: Sequence[Sequence[PassTime]]) -> dict[str, Any]:
    """Quartiles over the rounds, milliseconds, of every pass, every group and ``total``, by wall (or GPU) and CPU clock.

    A group's quartiles are those of its sums in each round.
    """
    groups: dict[str, dict[str, list[float]]] = {}
    for run in runs:
        for clock in ("wall", "cpu"):
            sums = dict.fromkeys((*GROUPS, "total"), 0.0)
            for one in run:
                where, ms = group(one), one.ms if clock == "wall" else one.cpu_ms
                sums[where] += ms
                sums["total"] += 0.0 if where == "gbuffer" else ms
            for name, ms in sums.items():
                groups.setdefault(name, {}).setdefault(clock, []).append(ms)
    passes = {
        one.name: {"wall": quartiles([run[i].ms for run in runs]), "cpu": quartiles([run[i].cpu_ms for run in runs])}
        for i, one in enumerate(runs[0])
    }
    return {
        "clock": runs[0][0].clock,
        "rounds": len(runs),
        "passes": passes,
        **{name: {clock: quartiles(values) for clock, values in clocks.items()} for name, clocks in groups.items()},
    }
