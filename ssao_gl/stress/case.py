"""What a case is, and the table of all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .outcomes import STEP

if TYPE_CHECKING:
    from .runner import CaseRunner


@dataclass(frozen=True, slots=True)
class Case:
    """A promise that every method keeps, or declares not to (``Method.exceptions``)."""

    name: str
    group: str
    promise: str
    unit: str
    """What ``measure`` returns, in words."""
    bound: float
    measure: Callable[[CaseRunner], float]
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
) -> Callable[[Callable[[CaseRunner], float]], Callable[[CaseRunner], float]]:
    """Return a decorator that makes a function a case; its docstring is the promise. Names are unique."""

    def register(measure: Callable[[CaseRunner], float]) -> Callable[[CaseRunner], float]:
        if name in _CASES:
            raise ValueError(f"two cases are called '{name}'")
        promise = " ".join((measure.__doc__ or "").split()).rstrip(".")
        _CASES[name] = Case(name, group, promise, unit, bound, measure, contract, asks, traps, why, once)
        return measure

    return register
