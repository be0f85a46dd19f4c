"""The table of all cases."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from . import cases as files
from .case import _CASES, Case


@cache
def cases() -> Mapping[str, Case]:
    """Every named case, in the order of the table."""
    order = [f"{files.__name__}.{name}" for name in files.__all__]
    return dict(sorted(_CASES.items(), key=lambda item: order.index(item[1].measure.__module__)))
