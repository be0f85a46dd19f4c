"""What a case is, and the table of all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .lab import Lab

STEP = 1 / 255 + 1e-6
"""One step of 8-bit visibility."""


class NotApplicable(Exception):
    """A case has nothing to measure here; the text says why."""


@dataclass(frozen=True, slots=True)
class Case:
    """A promise that every method keeps, or declares not to (``Method.exceptions``)."""

    name: str
    group: str
    promise: str
    unit: str
    """What ``measure`` returns, in words."""
    bound: float
    measure: Callable[[Lab], float]
    """Draws what it needs and returns by how much the promise is missed. Raises NotApplicable."""
    contract: str = ""
    """Name under which a method declares that its published definition breaks the promise, with a bound of its own."""
    asks: tuple[str, ...] = ()
    """Contracts that a method may declare with an infinite bound, and then refuses: kinds of camera that the case needs."""
    traps: tuple[int, ...] = ()
    """Numbers of the list of numerical traps that the case springs."""
    why: str = ""
    """Where the bound is not one step of 8-bit visibility: why."""
    once: bool = False
    """Whether it does not depend on the method, and is measured with the first one only."""


_CASES: dict[str, Case] = {}


def case(
    name: str,
    group: str,
    unit: str,
    bound: float = STEP,
    *,
    contract: str = "",
    asks: tuple[str, ...] = (),
    traps: tuple[int, ...] = (),
    why: str = "",
    once: bool = False,
) -> Callable[[Callable[[Lab], float]], Callable[[Lab], float]]:
    """Decorator that makes a function a case; its docstring is the promise. Names are unique."""

    def register(measure: Callable[[Lab], float]) -> Callable[[Lab], float]:
        if name in _CASES:
            raise ValueError(f"two cases are called '{name}'")
        promise = " ".join((measure.__doc__ or "").split()).rstrip(".")
        _CASES[name] = Case(name, group, promise, unit, bound, measure, contract, asks, traps, why, once)
        return measure

    return register


@cache
def cases() -> Mapping[str, Case]:
    """Every named case, in the order of the table."""
    from . import cases as files

    order = [f"{files.__name__}.{name}" for name in files.__all__]
    return dict(sorted(_CASES.items(), key=lambda item: order.index(item[1].measure.__module__)))
