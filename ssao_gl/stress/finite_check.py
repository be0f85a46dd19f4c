"""Methods whose mistakes show."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from ..glsl.preprocess import Define
from ..methods.base import Method
from ..settings import as_table


def with_finite_check(method: Method) -> Any:
    """Return the method with its visibility replaced by 1 where all that it is computed from is finite, and 0 elsewhere.

    Without this nothing would show: minima and maxima turn a NaN into some number on the way, and the last line of every
    method (``ssao_write``) turns the rest into open pixels. Filters give 1 for an image of ones, unless their weights are
    not finite.
    """
    return _finite(type(method))(**as_table(method))


@cache
def _finite(kind: Any) -> type:
    def defines(self: Any) -> Mapping[str, Define]:
        return {**kind.defines(self), "FINITE": 1}

    name = f"Finite{kind.__name__}"
    return type(name, (kind,), {"__slots__": (), "__doc__": kind.__doc__, "defines": defines})
