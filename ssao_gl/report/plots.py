"""The report's plots, by matplotlib: each as SVG for the page, and as SVG and PNG files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np

from ..errors import SettingsError
from ..experiment.points import MEDIAN, PlotPoint, marked, time_and_error
from ..experiment.scaling import AXES, exponents, series
from ..experiment.statistics import mean
from ..experiment.steps import ESTIMATE
from ..metrics.zones import ZONES
from .columns import by_variant
from .labels import place_labels
from .tables import split_means

INK = "#454647"
"""Colour of text and axes in the files; the page puts its own text colour there."""

COLORS = ("#2a78b8", "#d9731a", "#2e9a4f", "#c23b3b", "#8862bd", "#8d6450", "#cf6db0", "#9a9a22", "#17a2b1", "#5b6770")
FAR = 16.0
"""Pixels from a point to its name beyond which a line joins them."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">")


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure as two files' contents. ``name`` is the stem of the files."""

    name: str
    title: str
    svg: str
    png: bytes


def plots(found: Mapping[str, Any]) -> list[Plot]:
    """Every plot that the results have something for. Raises SettingsError without matplotlib."""
    made = []
    software = found["machine"]["software"]
    for at in found["sizes"]:
        size = at["size"]
        if at["shipped"]:
            made.append(_drawn(f"front-{size}", f"Error against time, {size}, as shipped", _front(at, at["shipped"])))
            # What else the machine does disturbs this clock least; on a GPU it says nothing.
            title = f"Error against CPU time, {size}, as shipped"
            made += [_drawn(f"front-cpu-{size}", title, _front(at, at["shipped"], clock="cpu"))] if software else []
        if at["fitted_held_out"]:
            fitted = {p["label"] for p in at["fitted_held_out"]}
            rest = [p for p in at["shipped_held_out"] if p["label"] not in fitted]
            every = [*at["fitted_held_out"], *rest]
            made.append(_drawn(f"fitted-{size}", f"Error against time, {size}, fitted", _front(at, every, held_out=True)))
        if any(p["errors"].get("rmse_net") for p in at["shipped"]):
            made.append(_drawn(f"zones-{size}", f"Squared error by zone, {size}", _zones(at, found)))
        made.append(_drawn(f"passes-{size}", f"Time per pass, {size}", _passes(at)))
    if any("model" in row for row in found["rows"]["split"]):
        made.append(_drawn("split", "Error split: model, sampling, filter", _split(found)))
    if any("times" in row for row in found["rows"]["scaling"]):
        made.append(_drawn("scaling", "Scaling", _scaling(found)))
    return made


def styles(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return method -> (colour, marker), the same in every plot of a report."""
    return {name: (COLORS[i % len(COLORS)], MARKERS[i % len(MARKERS)]) for i, name in enumerate(names)}


def _drawn(name: str, title: str, draw: Callable[[Any], None], size: tuple[float, float] = (9.0, 5.4)) -> Plot:
    try:
        import matplotlib
    except ImportError:
        raise SettingsError("plots need the package matplotlib: pip install 'ssao_gl[report]'") from None
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    colors = dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), INK)
    # Glyphs as outlines, and ids that do not change from run to run.
    settings: Any = {
        "svg.fonttype": "path",
        "svg.hashsalt": name,
        "font.size": 10,
        "axes.grid": True,
        "grid.alpha": 0.3,
        **colors,
    }
    with matplotlib.rc_context(settings):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        svg, png = BytesIO(), BytesIO()
        figure.savefig(svg, format="svg", transparent=True, metadata={"Date": None})
        figure.savefig(png, format="png", dpi=110, facecolor="white")
    return Plot(name, title, svg.getvalue().decode(), png.getvalue())


def _front(
    at: Mapping[str, Any], points: Sequence[PlotPoint], *, clock: str = "wall", held_out: bool = False
) -> Callable[[Any], None]:
    some = marked(points, len(at["held_out" if held_out else "views"]), clock)
    yard = at["baseline_ms" if clock == "wall" else "baseline_cpu_ms"]
    over = "held-out views" if held_out else "views"

    def draw(figure: Any) -> None:
        axes = figure.add_subplot()
        axes.set_xscale("log")
        style = styles(list(dict.fromkeys(p["family"] for p in at["shipped"])))
        for name in dict.fromkeys(p["family"] for p in some):
            color, marker = style[name]
            line = sorted(time_and_error(p, clock) for p in some if p["family"] == name)
            axes.plot(*zip(*line, strict=True), marker=marker, color=color, label=name, lw=1.2, ms=6, alpha=0.9)
        best = sorted(time_and_error(p, clock) for p in some if p["front"])
        if best:
            axes.step(*zip(*best, strict=True), where="post", color=INK, lw=5, alpha=0.18, label="Pareto front", zorder=1)
        for still, dashes in zip(at["constants"], (":", "--"), strict=False):
            error = still["errors"]["rmse"]
            axes.axhline(error, color=INK, lw=1, ls=dashes, label=f"{still['label']}: {error:.3f}")
        _ranges(axes, yard, [time_and_error(p, clock) for p in some])
        kind = "CPU milliseconds" if clock == "cpu" else "milliseconds"
        axes.set_xlabel(f"{kind} after the G-buffer (log scale; upper axis: multiples of the lecture's 4-tap pass)")
        axes.set_ylabel(f"RMSE against rays (mean over {over})")
        figure.legend(loc="outside right upper", frameon=False, fontsize=9)
        _name(figure, axes, some, [time_and_error(p, clock) for p in some], style)

    return draw


def _ranges(axes: Any, yard: float | None, places: Sequence[tuple[float, float]]) -> None:
    """Room around the points for their names, plain numbers on the time axis, and multiples of the baseline above it."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    times, errors = zip(*places, strict=True)
    axes.set_xlim(min(times) / 1.35, max(times) * 1.6)
    # The constants' lines are shown where they are near; the legend has their values anyhow.
    room = 0.25 * max(max(errors) - min(errors), 0.1 * max(errors), 1e-6)
    axes.set_ylim(max(0.0, min(errors) - room), max(errors) + room)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter("")
    if yard:
        above = axes.secondary_xaxis("top", functions=(lambda ms: ms / yard, lambda times: times * yard))
        above.xaxis.set_major_locator(LogLocator(base=2, numticks=20))
        above.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}×"))
        above.xaxis.set_minor_formatter("")


def _name(
    figure: Any,
    axes: Any,
    points: Sequence[PlotPoint],
    places: Sequence[tuple[float, float]],
    style: Mapping[str, tuple[str, str]],
) -> None:
    """Each point's name beside it, where nothing else is, joined to it by a line where that is far; the front in bold."""
    figure.draw_without_rendering()  # settles where the axes are
    renderer, to_data = figure.canvas.get_renderer(), axes.transData.inverted().transform
    lines = [line.get_transform().transform(line.get_xydata()) for line in axes.get_lines()]
    texts = [
        axes.text(
            *at, point["label"], fontsize=8.5, color=style[point["family"]][0], weight="bold" if point["front"] else "normal",
            va="bottom", zorder=5,
        )
        for point, at in zip(points, places, strict=True)
    ]  # fmt: skip
    sizes = np.array([(box.width, box.height) for box in (text.get_window_extent(renderer) for text in texts)])
    marks, frame = axes.transData.transform(places), axes.get_window_extent(renderer)
    corners = place_labels(marks, sizes, (frame.x0, frame.y0, frame.x1, frame.y1), lines)
    nearest = np.clip(marks, corners, corners + sizes)
    for text, mark, corner, near in zip(texts, marks, corners, nearest, strict=True):
        text.set_position(to_data(corner))
        if np.hypot(*(mark - near)) > FAR:
            axes.plot(*np.transpose(to_data([mark, near])), color=text.get_color(), lw=0.6, alpha=0.7, zorder=2)


def _bars(axes: Any, labels: Sequence[str], parts: Mapping[str, Sequence[float]], *, stacked: bool) -> None:
    """Horizontal bars, one group for each label, the first on top."""
    left = [0.0] * len(labels)
    for number, (name, values) in enumerate(parts.items()):
        shift = 0.0 if stacked else (number - (len(parts) - 1) / 2) * 0.8 / len(parts)
        places = [i + shift for i in range(len(labels))]
        height = 0.7 if stacked else 0.8 / len(parts)
        axes.barh(places, values, height, left=left if stacked else None, label=name, color=COLORS[number])
        if stacked:
            left = [a + b for a, b in zip(left, values, strict=True)]
    axes.set_yticks(range(len(labels)), labels)
    axes.invert_yaxis()
    axes.grid(axis="y", alpha=0)


def _passes(at: Mapping[str, Any]) -> Callable[[Any], None]:
    def draw(figure: Any) -> None:
        axes = figure.add_subplot()
        points = at["shipped"]
        names = {"method": "method or rays", "filter": "filter", "other": "other passes"}
        parts = {title: [p["wall"].get(name, 0.0) for p in points] for name, title in names.items()}
        _bars(axes, [p["label"] for p in points], parts, stacked=True)
        axes.set_xlabel("milliseconds after the G-buffer (means over views of medians)")
        figure.legend(loc="outside right upper", frameon=False, fontsize=9)
        figure.set_figheight(1.4 + 0.3 * len(points))

    return draw


def _zones(at: Mapping[str, Any], found: Mapping[str, Any]) -> Callable[[Any], None]:
    grouped = by_variant(row for row in found["rows"][ESTIMATE] if "errors" in row and row["view"] in at["views"])

    def part(rows: Sequence[Mapping[str, Any]], zone: str) -> float:
        """Return what a zone adds to the mean squared error, mean over views."""
        return 1e3 * (
            mean([(row["errors"][f"share_{zone}"] or 0) * (row["errors"]["rmse_net"] or 0) ** 2 for row in rows]) or 0
        )

    def draw(figure: Any) -> None:
        axes = figure.add_subplot()
        parts = {zone: [part(rows, zone) for rows in grouped.values()] for zone in ZONES}
        _bars(axes, list(grouped), parts, stacked=True)
        axes.set_xlabel("mean squared error without the truth's noise, times 1000 (mean over views)")
        figure.legend(loc="outside right upper", frameon=False, fontsize=9)
        figure.set_figheight(1.4 + 0.3 * len(grouped))

    return draw


def _split(found: Mapping[str, Any]) -> Callable[[Any], None]:
    means = split_means(found)

    def draw(figure: Any) -> None:
        axes = figure.add_subplot()
        shown = ("model", "sampling", "filter", "final")
        parts = {name: [float(one[name] or 0) for one in means.values()] for name in shown}
        _bars(axes, list(means), parts, stacked=False)
        axes.set_xlabel("RMSE (mean over views)")
        figure.legend(loc="outside right upper", frameon=False, fontsize=9)
        figure.set_figheight(1.4 + 0.55 * len(means))

    return draw


def _scaling(found: Mapping[str, Any]) -> Callable[[Any], None]:
    rows = found["rows"]["scaling"]
    slopes = {(one.family, one.axis): one.total for one in exponents(rows)}

    def draw(figure: Any) -> None:
        from matplotlib.ticker import FuncFormatter

        style = styles(list(dict.fromkeys(row["variant"] for row in rows)))
        plain = FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else f"{value / 1e6:g} M")
        every = figure.subplots(1, len(AXES))
        for axes, (axis, title) in zip(every, AXES.items(), strict=True):
            for (name, which), some in series(rows).items():
                if which == axis:
                    times = [row["times"]["total"]["wall"][MEDIAN] for row in some]
                    slope = slopes[name, axis]
                    label = f"{name}, exponent {slope:.2f}" if slope is not None else name
                    color, marker = style[name]
                    axes.plot([row["value"] for row in some], times, color=color, marker=marker, label=label, lw=1.2, ms=5)
            axes.set_xscale("log", base=10 if axis == "pixels" else 2)
            axes.set_yscale("log", base=10, subs=(2, 5))
            for ruler in (axes.xaxis, axes.yaxis):
                ruler.set_major_formatter(plain)
                ruler.set_minor_formatter(plain if ruler is axes.yaxis else "")
            axes.set_xlabel(title)
            axes.legend(frameon=False, fontsize=8)
        every[0].set_ylabel("milliseconds after the G-buffer")
        figure.set_figwidth(14)

    return draw
