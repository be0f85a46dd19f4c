"""Whether more time buys less error: each preset of a method against the cheaper ones, in each view."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .points import MEDIAN, PointRow

TOLERANCE = 0.03
"""A preset is out of order in a view where its RMSE is above that of a cheaper one by more than this share."""

CLEARLY = 0.75
"""A preset is cheaper than another when it is faster in at least this share of their common views: what noise decides is neither."""

ByView = Mapping[str, PointRow]


def preset_order(rows: Iterable[PointRow]) -> list[dict[str, Any]]:
    """Compare each preset with the best of its method's cheaper ones, in every view in which both took part.

    rows: of estimators in views of one size. Returns view, family, variant, cheaper (its label), rmse, cheaper_rmse, and
    share: above 0 is worse than the cheaper one.
    """
    families: dict[str, dict[str, dict[str, PointRow]]] = {}
    for row in rows:
        if row.get("errors", {}).get("rmse") is not None:
            families.setdefault(row["family"], {}).setdefault(row["variant"], {})[row["view"]] = row
    found = []
    for family, presets in families.items():
        for label, mine in presets.items():
            cheaper = {other: its for other, its in presets.items() if _cheaper(its, mine)}
            for view, row in mine.items():
                errors = {its[view]["errors"]["rmse"]: other for other, its in cheaper.items() if view in its}
                if errors:
                    error, best = row["errors"]["rmse"], min(errors)
                    about = {"view": view, "family": family, "variant": label, "cheaper": errors[best]}
                    share = error / best - 1 if best > 0 else float(error > 0)
                    found.append({**about, "rmse": error, "cheaper_rmse": best, "share": share})
    return found


def _cheaper(one: ByView, other: ByView) -> bool:
    both = one.keys() & other.keys()
    return bool(both) and sum(_time(one[view]) < _time(other[view]) for view in both) >= CLEARLY * len(both)


def _time(row: PointRow) -> float:
    return float(row["times"]["total"]["wall"][MEDIAN])
