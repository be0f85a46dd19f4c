"""Methods and filters whose mistakes show: what is computed before the last clamp, and before rounding to 8 bits."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from typing import Any

from ..graph import Pass, Tex
from ..methods import Method
from ..passes.blur import Blur
from ..settings import as_table
from ..sources import Define


def finite(method: Method) -> Any:
    """The method with its visibility replaced by 1 where it computes a finite number and 0 where it does not.

    Without this nothing would show: the last line of every method (``ssao_write``) turns a NaN into an open pixel.
    """
    return _finite(type(method))(**as_table(method))


def unrounded(blur: Blur) -> Any:
    """The filter with 32-bit floats of 0..255 for its result: what is NaN or out of range stays so."""
    return _unrounded(type(blur))(**as_table(blur))


@cache
def _finite(kind: Any) -> type:
    def defines(self: Any) -> Mapping[str, Define]:
        return {**kind.defines(self), "FINITE": 1}

    return _derived(kind, "Finite", defines=defines)


@cache
def _unrounded(kind: Any) -> type:
    def passes(self: Any, *given: Any) -> list[Pass]:
        return [
            dataclasses.replace(one, writes={n: _float(t) for n, t in one.writes.items()}) for one in kind.passes(self, *given)
        ]

    return _derived(kind, "Unrounded", passes=passes)


def _derived(kind: type, prefix: str, **methods: Any) -> type:
    return type(prefix + kind.__name__, (kind,), {"__slots__": (), "__doc__": kind.__doc__, **methods})


def _float(target: Tex) -> Tex:
    return dataclasses.replace(target, format="r32f") if target.format == "r8" else target
