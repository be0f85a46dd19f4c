"""The report's tables as data: one source for the page, for Markdown and for tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..experiment import pareto
from ..experiment.points import MEDIAN, PlotPoint, size_text, time_and_error
from ..experiment.scaling import AXES, exponents
from ..experiment.statistics import mean
from ..experiment.steps import ESTIMATE
from .columns import COSTS, ERRORS, KEYS, PREPARED, Cell, Column, Table, by_variant, text
from .zone_tables import zone_tables


def tables(found: Mapping[str, Any]) -> list[Table]:
    """Every table that the results have something for."""
    made = []
    for at in found["sizes"]:
        made += [_methods(at), _equal_time(found, at), _equal_error(found, at), _hypervolume(at)]
        made += [_fitted(found, at)] if at["fitted_held_out"] else []
        made += [_passes(at, found)]
    made += zone_tables(found)
    made += [_split(found), _rules(found), _scaling(found), _truth(found), _refused(found)]
    return [table for table in made if table.rows]


def _methods(at: Mapping[str, Any]) -> Table:
    rows: list[list[Cell]] = [
        [p["label"], "●" if p["front"] else "", p["views"], *_errors(p)[:2], *_costs(p), *_prepared(p), *_errors(p)[2:]]
        for p in at["shipped"]
    ]
    rows += [[c["label"], "", c["views"], *_errors(c)[:2], *[None] * 6, *_errors(c)[2:]] for c in at["constants"]]
    note = (
        f"Means over {len(at['views'])} views, as shipped, nothing fitted. ● is on the Pareto front."
        f" The baseline, the lecture's 4-tap pass alone, takes {text(at['baseline_ms'], '.1f')} ms. Rays: Embree on the CPU, then the same joint filter; its tree and the primary rays are prepared."
    )
    return Table(
        f"Error and time at {at['size']}",
        note,
        (Column("variant"), Column("front"), Column("views", "d"), *ERRORS[:2], *COSTS, *PREPARED, *ERRORS[2:]),
        rows,
        [bool(row[1]) for row in rows],
    )


def _errors(point: Mapping[str, Any]) -> list[Cell]:
    return [point["errors"].get(key) for key in KEYS]


def _costs(point: Mapping[str, Any]) -> list[Cell]:
    return [point["wall"]["total"], point["cpu"]["total"], point["ratio"], point["cpu_ratio"]]


def _prepared(point: Mapping[str, Any]) -> list[Cell]:
    return [point["prepared"]["ms"], point["prepared"]["bytes"] / 2**20]


def _by_family(at: Mapping[str, Any]) -> dict[str, list[PlotPoint]]:
    """Points that took part in every view, by family."""
    found: dict[str, list[PlotPoint]] = {}
    for point in at["shipped"]:
        if point["views"] == len(at["views"]):
            found.setdefault(point["family"], []).append(point)
    return found


def _equal_time(found: Mapping[str, Any], at: Mapping[str, Any]) -> Table:
    yard = at["baseline_ms"]
    budgets = [(factor, factor * yard) for factor in found["budgets"]] if yard else []
    rows = [[name, *(pareto.at_time(map(time_and_error, p), ms) for _, ms in budgets)] for name, p in _by_family(at).items()]
    columns = [Column(f"≤ {factor:g}× ({ms:.0f} ms)", ".4f") for factor, ms in budgets]
    note = "Smallest mean RMSE of any preset within a time after the G-buffer, given as a multiple of the baseline."
    return Table(f"Error at equal time, {at['size']}", note, (Column("method"), *columns), rows if budgets else [])


def _equal_error(found: Mapping[str, Any], at: Mapping[str, Any]) -> Table:
    rows = [
        [name, *(pareto.at_error(map(time_and_error, p), limit) for limit in found["limits"])]
        for name, p in _by_family(at).items()
    ]
    columns = [Column(f"RMSE ≤ {limit:g}", ".1f") for limit in found["limits"]]
    note = "Milliseconds after the G-buffer of the fastest preset that is at least this good."
    return Table(f"Time at equal error, {at['size']}", note, (Column("method"), *columns), rows)


def _hypervolume(at: Mapping[str, Any]) -> Table:
    volumes = at["hypervolume"]
    rows = [[name, value] for name, value in volumes.items() if name != "worst" and value is not None]
    note = (
        "Share of the box from 1/4 to 64 times the baseline (logarithmic) and from RMSE 0 to that of the constant mean"
        f" ({text(volumes['worst'], '.4f')}) that a method's presets dominate. The larger the better; ‘all’ leaves out what goes by more than a frame shows, like rays."
    )
    return Table(f"Hypervolume, {at['size']}", note, (Column("method"), Column("share", ".4f")), rows)


def _fitted(found: Mapping[str, Any], at: Mapping[str, Any]) -> Table:
    shipped = {point["label"]: point for point in at["shipped_held_out"]}
    rows: list[list[Cell]] = []
    for point in at["fitted_held_out"]:
        fit, before = found["fits"].get(point["label"], {}), shipped.get(point["label"])
        scalars = [fit.get(name) for name in ("radius", "strength", "power", "rmse")]
        rows.append([point["label"], *scalars, point["errors"]["rmse"], before and before["errors"]["rmse"], *_costs(point)])
    fitting, test = (", ".join(found["scenes"][name]) or "none" for name in ("fit", "test"))
    note = f"Fitted on: {fitting}. Frozen, and measured here, on: {test}. A' = clamp(1 - strength (1 - A), 0, 1)^power."
    if not found["scenes"]["test"]:
        note = f"Fitted and measured on the same scenes ({fitting}): an upper bound of what fitting gives, and no test of it."
    columns = (
        Column("variant"), Column("radius ×", ".2f"), Column("strength", ".3f"), Column("power", ".3f"),
        Column("RMSE where fitted", ".4f"), Column("RMSE", ".4f"), Column("RMSE as shipped", ".4f", "on the same views"), *COSTS,
    )  # fmt: skip
    return Table(f"Fitted track at {at['size']}", note, columns, rows)


def _passes(at: Mapping[str, Any], found: Mapping[str, Any]) -> Table:
    rows: list[list[Cell]] = []
    timed = [row for row in found["rows"][ESTIMATE] if row["view"] in at["views"] and "times" in row]
    for label, some in by_variant(timed).items():
        for name in dict.fromkeys(name for row in some for name in row["times"]["passes"]):
            ones = [row["times"]["passes"][name] for row in some if name in row["times"]["passes"]]
            quarters = [mean([one["wall"][i] for one in ones]) for i in (0, MEDIAN, 2)]
            rows.append([label, name, *quarters, mean([one["cpu"][MEDIAN] for one in ones])])
    columns = (
        Column("variant"), Column("pass"), Column("lower quartile", ".2f"), Column("median ms", ".2f"),
        Column("upper quartile", ".2f"), Column("CPU ms", ".2f"),
    )  # fmt: skip
    return Table(f"Time per pass, {at['size']}", "Quartiles over interleaved rounds, then means over views.", columns, rows)


SPLIT = ("model", "sampling", "estimator", "filter", "raw", "final")
"""Parts of an error; see :mod:`ssao_gl.experiment.error_split`."""


def split_means(found: Mapping[str, Any]) -> dict[str, dict[str, float | None]]:
    """Return label -> part of the error -> its mean over views."""
    grouped = by_variant(row for row in found["rows"]["split"] if "model" in row)
    return {label: {part: mean([row[part] for row in some]) for part in SPLIT} for label, some in grouped.items()}


def _split(found: Mapping[str, Any]) -> Table:
    rows: list[list[Cell]] = [[label, *parts.values()] for label, parts in split_means(found).items()]
    size = next((size_text(row["size"]) for row in found["rows"]["split"] if "size" in row), "")
    note = (
        f"At {size}. model: exhaustive screen-space reference against rays. sampling: unfiltered against that reference;"
        " estimator: the same with the noise averaged away. filter: filtered against unfiltered without noise. raw and final:"
        " unfiltered and filtered against rays. RMSE, means over views; parts cancel, so they are no sum."
    )
    return Table("Error split", note, (Column("variant"), *(Column(part, ".4f") for part in SPLIT)), rows)


def _scaling(found: Mapping[str, Any]) -> Table:
    columns = (
        Column("method"), Column("against"), Column("from"), Column("to"), Column("ms at first", ".1f"), Column("ms at last", ".1f"),
        Column("exponent, method", ".2f"), Column("exponent, all passes", ".2f"), Column("by CPU time", ".2f"),
    )  # fmt: skip
    note = "Time ~ size^exponent, least squares of logarithms, on the first view; 1 is linear, 0 is no dependence."
    rows: list[list[Cell]] = [
        [
            one.family, AXES[one.axis], f"{one.first:,.0f}", f"{one.last:,.0f}", one.ms_first, one.ms_last, one.method, one.total,
            one.cpu,
        ]
        for one in exponents(found["rows"]["scaling"])
    ]  # fmt: skip
    return Table("Scaling", note, columns, rows)


def _rules(found: Mapping[str, Any]) -> Table:
    keys = ("rule", "off", "on", "ratio", "cpu_ratio", "pixels", "taps", "difference", "bound")
    rows = [
        [row["view"], one["label"], *(one[key] for key in keys)]
        for row in found["rows"].get("rules", [])
        for one in row["rules"]
    ]
    columns = (
        Column("view"), Column("settings"), Column("rule", "", "all: every rule against none"),
        Column("ms without", ".1f", "all passes after the G-buffer, the rule switched off"), Column("ms with", ".1f"),
        Column("× time", ".2f", "with / without, median over rounds"), Column("× by CPU", ".2f"),
        Column("pixels", ".1%", "still to be shaded"), Column("taps", ".1%", "still to be taken in the method's own pass"),
        Column("difference", ".3g", "largest, of visibility and of the picture, in 1/255"),
        Column("bound", ".3g", "the most that it can be, in 1/255"),
    )  # fmt: skip
    note = (
        "The default method with each rule of leaving out on and off, in rounds in which all take turns. A rule that is not listed"
        " is not in force there; `ssao-gl explain` says why. Without a bound the difference is only measured."
    )
    return Table("What was left out", note, columns, rows)


def _truth(found: Mapping[str, Any]) -> Table:
    rows = [
        [
            view["view"], float(view["triangles"]), view["radius"], view["covered"], view["mean"], float(view["spp"]), view["stderr"],
            view["rays"] / 1e6, view["seconds"], view["rays"] / 1e6 / view["seconds"] if view["seconds"] else None,
        ]
        for view in found["rows"]["view"]
    ]  # fmt: skip
    columns = (
        Column("view"), Column("triangles", ",.0f"), Column("radius", ".4g", "scene units"), Column("covered", ".2f"),
        Column("mean visibility", ".4f"), Column("rays a pixel", ".0f"), Column("standard error", ".4f", "of a pixel, root mean square"),
        Column("million rays", ",.1f"), Column("seconds", ".1f"), Column("million rays/s", ".2f"),
    )  # fmt: skip
    return Table(
        "Truth", "Rays by Embree. Its standard error is part of every error that is not said to be net of it.", columns, rows
    )


def _refused(found: Mapping[str, Any]) -> Table:
    rows = [[row["variant"], row["view"], row["refused"]] for row in found["rows"][ESTIMATE] if "refused" in row]
    return Table("Not measured", "Views that a method refuses.", (Column("variant"), Column("view"), Column("reason")), rows)
