"""What a report is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import SettingsError, near_miss
from ..scene.projection import Size
from ..settings import as_table
from ..truth import Tracing
from .estimators import RAYS, Estimator, Rays, ScreenSpace
from .views import MeasuredView

SPLIT_PIXELS = 320 * 180
"""At most so many pixels has the image for which the exhaustive reference is drawn, unless a size is given."""

BUDGETS = (1.0, 2.0, 4.0, 8.0)
"""Times at which errors are compared, as multiples of the baseline."""

LIMITS = (0.10, 0.075, 0.06, 0.05)
"""Errors (RMSE) at which times are compared."""

SweepProgress = Callable[[str, float, float], None]
"""Called with what is being done, and the cost that is done and that there is in all, in the same unit."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Views, estimators and how they are measured.

    methods: what is drawn by the renderer; only of these are errors split, scalars fitted and times scaled. others: rays at few
    samples.
    """

    views: Sequence[MeasuredView]
    methods: Sequence[ScreenSpace]
    others: Sequence[Estimator] = tuple(map(Rays, RAYS))
    tracing: Tracing
    rounds: int = 5
    fit: tuple[str, ...] = ()
    """Scenes on which scalars are fitted; none: no fitted track."""
    split: Size | None = None
    """Size at which errors are split into model, sampling and filter; None: not at all."""
    scaling: bool = False
    rules: bool = False
    """Whether the rules of leaving out are measured, each on and off."""

    @property
    def estimators(self) -> list[Estimator]:
        """Everything that is measured: the methods, and what they are compared with."""
        return [*self.methods, *self.others]

    @property
    def contents(self) -> dict[str, str]:
        """View -> hash of what is seen there."""
        return {view.name: view.content for view in self.views}

    def header(self, machine: dict[str, Any], code: str) -> dict[str, Any]:
        """Return what every measured row depends on beside its key: another header, another journal."""
        return {
            "format": 2,
            "code": code,
            "truth": as_table(self.tracing),
            "rounds": self.rounds,
            "machine": {
                key: machine[key] for key in ("provider", "renderer", "gl_version", "cpu", "cores", "threads", "packages")
            },
        }


def check_rounds(rounds: int) -> None:
    """Raise SettingsError unless there is at least one round of timing."""
    if rounds < 1:
        raise SettingsError(f"--rounds {rounds}: must be at least 1")


def fitting_scenes(asked: str | None, views: Sequence[MeasuredView]) -> tuple[str, ...]:
    """Names of the scenes to fit on: those asked for by commas, none for ``none``, else every second by name.

    The other scenes test the fit; so no choice is made by hand. Raises SettingsError for a scene that is not there.
    """
    names = sorted({view.scene for view in views})
    if asked is None:
        return tuple(names[::2])
    if asked == "none":
        return ()
    chosen = tuple(name.strip() for name in asked.split(",") if name.strip())
    for name in chosen:
        if name not in names:
            raise SettingsError(f"--fit {name}: no such scene here; there are {', '.join(names)}.{near_miss(name, names)}")
    return chosen


def split_size(size: Size) -> Size:
    """``size`` shrunk to at most ``SPLIT_PIXELS``, of the same shape."""
    scale = min(1.0, (SPLIT_PIXELS / (size[0] * size[1])) ** 0.5)
    return max(1, round(size[0] * scale)), max(1, round(size[1] * scale))


def folder_name(text: str) -> str:
    """Return a text as part of a file name."""
    return "".join(c if c.isalnum() or c in "._=-" else "-" for c in text)


def images_of(folder: Path) -> Path:
    """Where a report keeps its pictures."""
    return folder / "images"
