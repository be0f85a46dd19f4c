"""Frames that are kept for the next call: programs bound, textures made."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable
from typing import Generic, TypeVar

from ..graph.plan import FrameLayout, Plan
from .executor import FrameExecutor
from .frame_targets import FrameTargets
from .programs import GpuResources

FrameKey = TypeVar("FrameKey", bound=Hashable)

MOST_EXECUTORS = 16
"""Of one layout, at most so many stay: settings that change all the time must not pile up."""


class FrameCache(Generic[FrameKey]):
    """Executors by key. The targets of the ``keep`` layouts that were used last stay, and serve every plan of their layout."""

    def __init__(self, resources: GpuResources, keep: int = 1) -> None:
        self._resources, self._keep = resources, keep
        self._kept: list[tuple[FrameTargets, dict[FrameKey, FrameExecutor]]] = []
        """By last use: the last one used is last."""

    def get(self, key: FrameKey, make: Callable[[], Plan], check: Callable[[Plan], None] = lambda plan: None) -> FrameExecutor:
        """Return the executor of a key; ``make`` gives its plan where there is none yet, ``check`` may refuse to draw it."""
        found = next((i for i, (_, executors) in enumerate(self._kept) if key in executors), None)
        if found is not None:
            self._kept.append(self._kept.pop(found))
            return self._kept[-1][1][key]
        plan = make()
        layout = plan.layout
        same = next((i for i, (targets, _) in enumerate(self._kept) if targets.layout == layout), None)
        if same is not None:
            targets, executors = self._kept.pop(same)
            while len(executors) >= MOST_EXECUTORS:
                executors.pop(next(iter(executors)))
        else:
            while len(self._kept) >= self._keep:
                self._kept.pop(0)[0].release()
            check(plan)
            targets, executors = FrameTargets(self._resources, layout), {}
        executors[key] = FrameExecutor(self._resources, plan, targets)
        self._kept.append((targets, executors))
        return executors[key]

    @property
    def keys(self) -> list[FrameKey]:
        """All that have an executor."""
        return [key for _, executors in self._kept for key in executors]

    def retain(self, layouts: Collection[FrameLayout]) -> None:
        """Free the targets of all other layouts."""
        for targets, _ in self._kept:
            if targets.layout not in layouts:
                targets.release()
        self._kept = [kept for kept in self._kept if kept[0].layout in layouts]

    def clear(self) -> None:
        """Free all targets."""
        for targets, _ in self._kept:
            targets.release()
        self._kept = []
