"""All that a report knows, as one plain mapping: what results.json holds, and what pages and tables are made from."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import FormatError
from ..io.atomic import why_unreadable
from ..io.journal import Journal
from .fit_track import fits
from .points import MEDIAN, constants, method_hypervolume, points, size_text
from .preset_order import preset_order
from .statistics import mean
from .steps import ESTIMATE
from .sweep import BUDGETS, LIMITS, Sweep

FORMAT = "ssao_gl report 2"
KINDS = ("view", ESTIMATE, "fitted", "split", "scaling", "rules")

Results = dict[str, Any]


def results(sweep: Sweep, journal: Journal, machine: Mapping[str, Any], made: str, command: str) -> Results:
    """Return what the journal has for a sweep, and what follows from it."""
    names = {view.name for view in sweep.views}
    labels = {one.label for one in sweep.estimators} | {""}
    methods = {one.family for one in sweep.methods} if sweep.scaling else set()
    rows = {
        kind: [
            row
            for row in journal.rows(kind)
            if row["view"] in names and row["variant"] in (methods if kind == "scaling" else labels)
        ]
        for kind in KINDS
    }
    found_fits = fits(sweep, journal)
    keys = {label: scalars.key for label, (scalars, _) in found_fits.items()}
    rows["fitted"] = [row for row in rows["fitted"] if row["at"] == keys.get(row["variant"])]
    rows["rules"] = rows["rules"] if sweep.rules else []
    rows["split"] = [row for row in rows["split"] if sweep.split and row["at"] == size_text(sweep.split)]
    scenes = list(dict.fromkeys(view.scene for view in sweep.views))
    found = {
        "format": FORMAT,
        "made": made,
        "command": command,
        "machine": dict(machine),
        "settings": sweep.header(dict(machine), ""),
        "budgets": list(BUDGETS),
        "limits": list(LIMITS),
        "scenes": {"fit": list(sweep.fit), "test": [name for name in scenes if name not in sweep.fit]},
        "order": [one.label for one in sweep.estimators],
        "families": list(dict.fromkeys(one.family for one in sweep.estimators)),
        "fits": {label: {**dataclasses.asdict(scalars), "rmse": error} for label, (scalars, error) in found_fits.items()},
        "rows": rows,
    }
    found["sizes"] = [_at_size(found, size_text(size)) for size in dict.fromkeys(view.size for view in sweep.views)]
    return found


def _at_size(found: Results, size: str) -> dict[str, Any]:
    """Return the points of all tracks at one size."""
    rows = found["rows"]
    views = [row for row in rows["view"] if size_text(row["size"]) == size]
    every = {row["view"] for row in views}
    fitting = {row["view"] for row in views if row["scene"] in found["scenes"]["fit"]}
    # With nothing held out the fit can only be shown where it was made; the page says so.
    held = (every - fitting) or every
    still = constants(views, fitting)
    timed = _one_a_view(rows[ESTIMATE], every)
    baseline, by_cpu = (mean([row["baseline"][clock][MEDIAN] for row in timed]) for clock in ("wall", "cpu"))
    shipped = points(rows[ESTIMATE], every, track="as shipped")
    worst = still[-1]["errors"]["rmse"] if still else 0.0
    families = dict.fromkeys(point["family"] for point in shipped)
    return {
        "size": size,
        "views": sorted(every),
        "held_out": sorted(held),
        "baseline_ms": baseline,
        "baseline_cpu_ms": by_cpu,
        "constants": still,
        "shipped": shipped,
        "shipped_held_out": points(rows[ESTIMATE], held, track="as shipped"),
        "fitted_held_out": points(rows["fitted"], held, track="fitted"),
        "preset_order": preset_order(row for row in rows[ESTIMATE] if row["view"] in every),
        "hypervolume": {
            "worst": worst,
            "all": method_hypervolume([p for p in shipped if p["realtime"]], baseline, worst),
            **{name: method_hypervolume([p for p in shipped if p["family"] == name], baseline, worst) for name in families},
        },
    }


def _one_a_view(rows: list[dict[str, Any]], views: set[str]) -> list[dict[str, Any]]:
    """Return the first row with a baseline of each view."""
    first: dict[str, dict[str, Any]] = {}
    for row in rows:
        if row["view"] in views and row.get("baseline"):
            first.setdefault(row["view"], row)
    return list(first.values())


def load_results(path: Path) -> Results:
    """Read a results.json. Raises FormatError for a file that is none, or damaged."""
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected the results.json of a report")
    try:
        found: Results = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: damaged, or not JSON ({' '.join(str(error).split())[:120]})") from None
    if not isinstance(found, dict) or found.get("format") != FORMAT or not isinstance(found.get("rows"), dict):
        raise FormatError(f"{path}: not the results.json of a report ('format' is not '{FORMAT}')")
    return found
