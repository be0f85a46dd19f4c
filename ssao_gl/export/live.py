"""Settings that an exported pipeline leaves open: those that change nothing but numbers, and how they do it.

What depends on a setting is found by planning with other values of it, and compared: nothing is said twice.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError
from ..graph.draws import Fullscreen, Uniform, ViewValue
from ..graph.plan import Plan
from ..pipeline.settings import Settings
from ..scene.srgb import decode
from ..settings import Limits, as_table, limits
from .formulas import Formula, components

LIVE: Mapping[str, tuple[tuple[str, str], ...]] = {
    "radius": (("method", "radius"),),
    "strength": (("shading", "ambient"),),
    "power": (("method", "power"), ("shading", "power")),
    "tint": (("shading", "tint"),),
    "thickness": (("method", "thickness"),),
    "tolerance": (("blur", "tolerance"),),
    "intensity": (("method", "intensity"),),
    "bias": (("method", "bias"),),
}
"""Name of a live setting -> the fields that it may be, the first that there is: (group of settings, field)."""

GREYS: Mapping[str, float] = {text: float(decode(int(text[1:3], 16) / 255)) for text in ("#404040", "#808080", "#bfbfbf")}
"""Colours that are tried -> their linear light. A colour stays open as three numbers of that."""

Place = tuple[int, str, int]
"""Number of a step, name of a uniform, number of a component."""


@dataclass(frozen=True, slots=True)
class LiveSetting:
    """A setting that stays open. ``value``: what it was exported with."""

    name: str
    field: str
    value: float | list[float]
    limits: Limits
    parts: Mapping[Place, Formula]
    """Where it stands, and as which formula."""


@dataclass(frozen=True, slots=True)
class LiveSettings:
    """Those that stay open, and why others do not."""

    open: Mapping[str, LiveSetting]
    fixed: Mapping[str, str]

    def parts(self, step: int, uniform: str) -> dict[int, Formula]:
        """Return number of a component -> formula, of one uniform."""
        every = (item for setting in self.open.values() for item in setting.parts.items())
        return {place[2]: formula for place, formula in every if place[:2] == (step, uniform)}


def live_settings(settings: Settings, plan_of: Callable[[Settings], Plan]) -> LiveSettings:
    """Find what may stay open. ``plan_of``: the plan of some settings, at one size."""
    plan = plan_of(settings)
    found: dict[str, LiveSetting] = {}
    fixed: dict[str, str] = {}
    for name, fields in LIVE.items():
        field = next((f for f in fields if _has(settings, *f)), None)
        if field is None:
            fixed[name] = f"{settings.method.name} and its filter have none"
            continue
        try:
            made = _live_setting(name, field, settings, plan, plan_of)
            taken = {place for other in found.values() for place in other.parts} & set(made.parts)
            if taken:
                raise SettingsError(f"it shares the uniform {sorted(taken)[0][1]} with another setting")
            found[name] = made
        except SettingsError as reason:
            fixed[name] = str(reason)
    return LiveSettings(found, fixed)


def _has(settings: Settings, group: str, field: str) -> bool:
    record = getattr(settings, group)
    return record is not None and any(f.name == field for f in dataclasses.fields(record))


def _live_setting(
    name: str, field: tuple[str, str], settings: Settings, plan: Plan, plan_of: Callable[[Settings], Plan]
) -> LiveSetting:
    """Raise SettingsError, with the reason alone, for one that changes more than numbers in proportion."""
    group, key = field
    record = getattr(settings, group)
    rule = next(limits(f) for f in dataclasses.fields(record) if f.name == key)
    value = as_table(record)[key]
    many = isinstance(value, str)  # a colour
    tried_as: Mapping[Any, float] = GREYS if many else {one: one for one in _tried(rule)}
    try:
        plans = [
            plan_of(dataclasses.replace(settings, **{group: dataclasses.replace(record, **{key: one})})) for one in tried_as
        ]
    except SettingsError as error:
        raise SettingsError(f"not every value of it can be drawn: {error}") from None
    parts: dict[Place, Formula] = {}
    base: list[float] = []
    for place, numbers in _numbers(plan, plans):
        own, *tried = numbers
        if len(set(tried)) == 1 and own == tried[0]:
            continue
        factor, inverse = _proportion(list(tried_as.values()), tried, place[1])
        parts[place] = (
            {"setting": name}
            | ({"part": place[2]} if many else {})
            | ({} if factor == 1 else {"factor": factor})
            | ({"inverse": True} if inverse else {})
        )
        base.append(1 / (factor * own) if inverse else own / factor)
    if not parts:
        raise SettingsError("nothing that is drawn depends on it")
    known = base if many else float(base[0] if value is None else value)
    return LiveSetting(name, f"{group}.{key}", known, Limits(rule.doc, rule.unit, low=0, high=1) if many else rule, parts)


def _tried(rule: Limits) -> Sequence[float]:
    """Return three values within the limits."""
    low = rule.above if rule.above is not None else rule.low if rule.low is not None else 0.0
    high = low + 1 if rule.high is None else min(rule.high, low + 1)
    return [low + (high - low) * share for share in (0.3125, 0.625, 0.4375)]


def _numbers(plan: Plan, plans: Sequence[Plan]) -> list[tuple[Place, list[float]]]:
    """Return every number in the uniforms of a plan, and those of the others in its place."""
    found = []
    for index, steps in enumerate(zip(plan.steps, *(other.steps for other in plans), strict=False)):
        draws = [step.task.draw for step in steps]
        if len({len(other.steps) for other in (plan, *plans)}) > 1 or not all(isinstance(d, Fullscreen) for d in draws):
            raise SettingsError("it decides which passes there are")
        every = [draw for draw in draws if isinstance(draw, Fullscreen)]
        if any(_frozen(draw) != _frozen(every[0]) for draw in every):
            raise SettingsError("it changes the shader or the tables")
        for name in every[0].uniforms:
            columns = [components(draw.uniforms[name]) for draw in every]
            found += [((index, name, i), list(row)) for i, row in enumerate(zip(*columns, strict=True))]
    return found


def _frozen(draw: Fullscreen) -> Any:
    """Return all of a draw but the numbers in its uniforms."""
    kinds = {name: _kind(value) for name, value in draw.uniforms.items()}
    return draw.shader, draw.samplers, draw.tables, draw.defines, kinds


def _kind(value: Uniform) -> Any:
    return dataclasses.replace(value, factor=1.0) if isinstance(value, ViewValue) else len(components(value))


def _proportion(values: Sequence[float], numbers: Sequence[float], uniform: str) -> tuple[float, bool]:
    """Return the factor by which numbers are proportional to values, or to their inverses. Raises SettingsError."""
    for inverse in (False, True):
        factors = [1 / (n * v) if inverse and n else n / v for n, v in zip(numbers, values, strict=True)]
        if all(math.isclose(factor, factors[0], rel_tol=1e-12) for factor in factors) and factors[0]:
            return _short(factors[0]), inverse
    raise SettingsError(f"the uniform {uniform} depends on it in a way that is no proportion")


def _short(value: float) -> float:
    """Return the number with the fewest digits that differs by less than rounding does."""
    return next(short for digits in range(1, 18) if math.isclose(short := float(f"{value:.{digits}g}"), value, rel_tol=1e-14))
