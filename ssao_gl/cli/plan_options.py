"""``--budget-ms`` and ``--max-error``: what is asked of the planner, and what is told of its choice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import SettingsError
from ..planner import CLOCKS, Choice, Target
from .help_pages import OCCLUSION
from .options import LookOptions
from .output import print_table


@Parameter(name="*", group=OCCLUSION)
@dataclass(frozen=True, kw_only=True)
class PlanOptions:
    """Targets, from which method and preset follow."""

    budget_ms: Annotated[
        float | None,
        Parameter(
            help="Choose the preset: least error predicted within this time a frame, CPU time on software renderers."
            " [default: none]",
            negative="",
            allow_leading_hyphen=True,
        ),
    ] = None
    max_error: Annotated[
        float | None,
        Parameter(
            help="Choose the preset: least time predicted within this RMSE of visibility against rays. [default: none]",
            negative="",
            allow_leading_hyphen=True,
        ),
    ] = None

    def target(self, look: LookOptions) -> Target | None:
        """None when nothing is asked for. Raises SettingsError for targets that cannot be, or beside options that it decides."""
        if self.budget_ms is None and self.max_error is None:
            return None
        for option, value in (("--preset", look.preset), ("--samples", look.samples), ("--rays", look.rays)):
            if value is not None:
                raise SettingsError(f"{option} {value}: --budget-ms and --max-error choose that; leave one or the other out")
        return Target(budget_ms=self.budget_ms, max_error=self.max_error)


def compared(planned: Mapping[str, Any]) -> str:
    """Return what was predicted of a picture, and what it took, on one line. ``planned``: of its report."""
    return (
        f"planned: {planned['chosen']}, of {planned['of']}; predicted {planned['predicted_ms']:.3g} ms and RMSE"
        f" {planned['predicted_error']:.3f}, took {planned['took_ms']:.3g} ms ({CLOCKS[planned['clock']]})"
    )


def expected(choice: Choice) -> str:
    """Return what is predicted of frames by a choice, on one line."""
    one = choice.prediction
    return f"planned: {one.name}, of {len(choice.considered)}; predicted {one.ms:.3g} ms and RMSE {one.error:.3f} ({CLOCKS[choice.clock]})"


def listed(choice: Choice) -> dict[str, Any]:
    """Everything that was considered, as plain values."""
    return {
        **asdict(choice.target),
        "clock": choice.clock,
        "chosen": choice.prediction.name,
        "considered": [asdict(one) for one in choice.considered],
    }


def tell(choice: Choice) -> None:
    """Print everything that was considered."""
    print_table(
        f"predicted ({CLOCKS[choice.clock]}); chosen for {choice.target.describe()}: {choice.prediction.name}",
        ("settings", "ms a frame", "RMSE", ""),
        [
            (one.name, f"{one.ms:.3g}", f"{one.error:.3f}", "chosen" if one == choice.prediction else "")
            for one in choice.considered
        ],
    )


def drawn_at_once(target: Target | None, tiles: object) -> None:
    """Raise SettingsError when there is a target for a picture in tiles."""
    if target is not None and tiles is not None:
        raise SettingsError(
            "--budget-ms and --max-error are for pictures that are drawn at once, and this one would be drawn in tiles;"
            " choose a smaller --size, and no --tile"
        )
