"""``ssao-gl bench``: what each pass costs on this driver, as ratios taken in one interleaved run."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..errors import SettingsError
from ..gl.overhead import without_draws
from ..gl.timer import PassTime
from ..graph.frame_graph import compile
from ..methods.lecture import Lecture
from ..pipeline.build import plan_render
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from .options import GlOption, JsonOption, LookOptions, ViewOptions
from .output import print_table, progress, say, write_json
from .tokens import WHOLE


def bench(
    scene: Path | None = None,
    *,
    rounds: Annotated[int, WHOLE, Parameter(help="Interleaved rounds; medians are reported.")] = 15,
    gl: GlOption = "auto",
    json: JsonOption = None,
    view: ViewOptions = ViewOptions(),
    look: LookOptions = LookOptions(),
) -> int:
    """Time every pass, in wall and in CPU time, beside the lecture's 4-tap shader and a G-buffer of depth alone.

    Parameters
    ----------
    scene
        Scene file. Without it: the embedded scene.
    """
    if rounds < 1:
        raise SettingsError(f"--rounds {rounds}: must be at least 1")
    settings, size = look.settings(), view.pixels()
    loaded = view.load(scene)
    settings = look.settled(settings, loaded.default_radius)
    camera = view.choose(loaded)
    with Renderer(gl) as renderer:
        passes = _passes(renderer, loaded, camera, size, settings, rounds)
        host = _host(renderer, loaded, camera, settings)
        where = f"{renderer.ctx.provider}, {renderer.ctx.renderer}"
    look.dump(settings)
    lecture = passes["lecture (4 taps)"][0]
    bare = passes["G-buffer"][0]
    print_table(
        f"{loaded.name} {camera.name}, {loaded.contents}, {size[0]}x{size[1]}, {where}, medians of {rounds} rounds",
        ("pass", "wall ms", "cpu ms", "x lecture", "x G-buffer"),
        [
            (name, f"{wall:.1f}", f"{cpu:.1f}", f"{wall / lecture:.2f}", f"{wall / bare:.2f}")
            for name, (wall, cpu) in passes.items()
        ],
    )
    say(f"planning {host['plan_ms']:.2f} ms; Python in a frame of {host['passes']} passes {host['frame_ms']:.2f} ms")
    if json:
        content = {name: {"wall_ms": wall, "cpu_ms": cpu} for name, (wall, cpu) in passes.items()}
        write_json(
            json, {"where": where, "size": list(size), "scene": loaded.name, "camera": camera.name, "passes": content, **host}
        )
    return 0


def _passes(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings, rounds: int
) -> dict[str, tuple[float, float]]:
    """Median (wall, CPU) milliseconds by pass: variants take turns, so a busy neighbour slows all alike."""
    lecture = Settings(method=Lecture(), blur=None)
    variants: list[tuple[Settings, tuple[str, ...], dict[str, str]]] = [  # and the roles that are shown, under other labels
        (settings, ("depth",), {"gbuffer": "depth alone"}),
        (settings, ("depth", "normal", "color"), {"gbuffer": "G-buffer"}),
        (lecture, ("visibility",), {"occlusion": "lecture (4 taps)"}),
        (settings, ("image",), {}),
    ]
    found: dict[str, list[tuple[float, float]]] = {}
    for number in progress(range(rounds + 2), "bench", rounds + 2):
        for one, aovs, names in variants:
            times = renderer.time(scene, camera, size, one, aovs=aovs)
            if number < 2:  # compiling, warming up
                continue
            for label, some in (_alone(times, names) if names else _every(times)).items():
                found.setdefault(label, []).append((sum(p.ms for p in some), sum(p.cpu_ms for p in some)))
    return {
        name: (float(np.median([r[0] for r in runs])), float(np.median([r[1] for r in runs]))) for name, runs in found.items()
    }


def _alone(times: Sequence[PassTime], names: Mapping[str, str]) -> dict[str, list[PassTime]]:
    """Return the passes of some roles, under a label for each."""
    return {label: [p for p in times if p.role == role] for role, label in names.items()}


def _every(times: Sequence[PassTime]) -> dict[str, list[PassTime]]:
    """Return each pass but the G-buffer by its name, the filter's together, and all."""
    found = {p.name: [p] for p in times if p.role != "gbuffer"}
    blur = [p for p in times if p.role == "denoise"]
    return {**found, **({"blur in all": blur} if blur else {}), "whole frame": list(times)}


def _host(renderer: Renderer, scene: Scene, camera: Camera, settings: Settings) -> dict[str, float]:
    """Milliseconds of Python: making a plan, and running a frame of one thing with the driver's draws left out."""
    settings = settings.with_radius(1.0)
    plan = plan_render(settings, (1280, 720))
    tasks = [step.task for step in plan.steps]
    plan_ms = _median_ms(lambda: compile(tasks, (1280, 720), ["image"]), 200)
    spheres, volumes = () if scene.meshes else scene.spheres[:1], () if scene.meshes or scene.spheres else scene.volumes[:1]
    one = dataclasses.replace(scene, meshes=scene.meshes[:1], spheres=spheres, volumes=volumes)
    frame = renderer.frame(one, camera, (1, 1), settings, aovs=("image",))
    frame()
    with without_draws():
        frame_ms = _median_ms(frame, 200)
    return {"plan_ms": plan_ms, "frame_ms": frame_ms, "passes": len(plan.steps)}


def _median_ms(work: Callable[[], object], count: int) -> float:
    """Median milliseconds of ``work``."""
    times = []
    for _ in range(count):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return 1e3 * float(np.median(times))
