"""What the renderer did in 0.1, and others do now. It goes in 0.3."""

from __future__ import annotations

import functools
import importlib
import warnings
from collections.abc import Callable, Mapping

from .picture import Picture


def drawn_to_budget(function: str, budget: Mapping[str, float | None]) -> Callable[..., Picture] | None:
    """Return the function of the planner that draws to a budget: what ``Renderer`` itself did in 0.1.

    None where no budget is given.
    """
    if unknown := set(budget) - {"budget_ms", "max_error"}:
        raise TypeError(f"Renderer: there is no argument {', '.join(map(repr, sorted(unknown)))}")
    if all(value is None for value in budget.values()):
        return None
    warnings.warn(
        "Renderer: budget_ms and max_error will go in 0.3; use ssao_gl.plan and its settings, or ssao_gl.render",
        DeprecationWarning,
        stacklevel=4,
    )
    planner = importlib.import_module("ssao_gl.planner")  # by name: the planner draws with renderers, which know nothing of it
    target = planner.Target(**budget)
    return functools.partial(getattr(planner, function), target=target)
