"""``ssao-gl truth``: ray-traced ambient occlusion, to measure others by."""

from __future__ import annotations

import logging
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..io import images
from ..render.picture import Picture
from ..sampling.falloff import Falloff
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth import Tracing, Truth, trace
from ..truth.settings import MOST_SPP, NORMALS, SPP
from .cache_options import CacheOptions
from .help_pages import OUTPUT, RAYS
from .options import ViewOptions
from .output import check_json, check_output, counted, own_length, say, write_json
from .signals import Terminated
from .tokens import WHOLE, parse_share


@Parameter(name="*", group=RAYS)
@dataclass(frozen=True, kw_only=True)
class RayOptions:
    """Which rays are traced, and how many."""

    radius: Annotated[
        str | None,
        Parameter(
            help="Reach of occlusion in scene units, or a share of the scene's size, like 10%."
            " [default: the camera file's ao_radius, else 3%]",
            allow_leading_hyphen=True,
        ),
    ] = None
    falloff: Annotated[str, Parameter(help=f"How a blocker counts with distance: {', '.join(Falloff)}.")] = Falloff.HARD.value
    normals: Annotated[
        str, Parameter(help=f"Hemisphere about the triangle's or the interpolated normal: {' or '.join(NORMALS)}.")
    ] = NORMALS[0]
    spp: Annotated[
        int | None,
        WHOLE,
        Parameter(
            help=f"Rays a pixel, rounded up to whole batches; with --max-stderr at most so many. [default: {SPP}; with --max-stderr {MOST_SPP}]",
        ),
    ] = None
    max_stderr: Annotated[
        float | None, Parameter(help="Stop when the root mean square of the pixels' standard errors is below this.")
    ] = None
    seed: Annotated[int, WHOLE, Parameter(help="Of the directions.")] = 0

    def tracing(self) -> Tracing:
        """Return the settings of the rays. Raises SettingsError."""
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        return Tracing(**{**given, "radius": own_length(self.radius)})

    def settled(self, tracing: Tracing, scene: Scene) -> Tracing:
        """Return what is traced, with a radius that was given as a share of the scene."""
        share = parse_share(self.radius or "")
        return tracing if share is None else tracing.with_radius(scene.default_radius(share))


def truth(
    scene: Path | None = None,
    *,
    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            allow_leading_hyphen=True,
            help="PNG, NPY or EXR file for visibility, or a folder for visibility, standard error and depth as NPY and PNG.",
        ),
    ] = Path("truth.png"),
    rays: RayOptions = RayOptions(),
    cache: CacheOptions = CacheOptions(),
    json: Annotated[
        Path | None,
        Parameter(
            group=OUTPUT, negative="", help="Write settings, standard error, rays and seconds to this file; - prints them."
        ),
    ] = None,
    bench: Annotated[
        bool,
        Parameter(
            group=RAYS, negative="", help="Write nothing; print how fast rays are, and how much of Embree's speed that is."
        ),
    ] = False,
    view: ViewOptions = ViewOptions(),
) -> int:
    """Trace ambient occlusion, or obscurance, of what a camera sees. The same command goes on where Ctrl-C cut it.

    Parameters
    ----------
    scene
        Scene file. Without it: the embedded scene.
    """
    tracing, size = rays.tracing(), view.pixels()
    if bench:
        return _bench(view, scene, rays)
    check_output("-o", output, images.SUFFIXES, folder=True)
    check_json(json)
    folder = cache.folder()
    loaded = view.load(scene)
    tracing = rays.settled(tracing, loaded)
    camera = view.choose(loaded)
    found = _traced(loaded, camera, size, tracing, folder)
    report = {"scene": loaded.name, "camera": camera.name or "unnamed"}
    paths = _picture(found, **report).save(output)
    where = str(paths[0]) if len(paths) == 1 else f"{output} ({len(paths)} files)"
    say(f"{where}: {_summary(loaded, found)}")
    if json:
        write_json(json, report | _numbers(loaded, found))
    return 0


def _bench(view: ViewOptions, path: Path | None, rays: RayOptions) -> int:
    """Print million rays a second by number of threads: of bare embreex calls, and of the tracer that makes the rays, too."""
    from ..truth import surface
    from ..truth.bench import bench

    scene = view.load(path)
    camera = view.choose(scene)
    tracing = rays.settled(rays.tracing(), scene)
    tracing = replace(tracing, radius=tracing.radius or camera.ao_radius or scene.default_radius())
    for workers, (bare, traced) in bench(surface(scene, camera, view.pixels()), tracing).items():
        threads = f"{workers} thread{'s' if workers > 1 else ''}"
        say(f"{threads}: embreex {bare:.2f}, ssao_gl {traced:.2f} million rays/s: {100 * traced / bare:.0f} %")
    return 0


def _traced(scene: Scene, camera: Camera, size: Size, tracing: Tracing, folder: Path | None) -> Truth:
    """Trace, with a progress bar; say so when it is cut, and when it is less exact than was asked for."""
    log = logging.getLogger("ssao_gl")
    with counted("tracing") as progress:
        try:
            found = trace(scene, camera, size, tracing, cache=folder, progress=progress)
        except (KeyboardInterrupt, Terminated) as error:
            if folder is not None:
                error.add_note("what is traced so far is kept; the same command goes on from there")
            raise
    limit = tracing.max_stderr
    if limit is not None and found.noise > limit:
        words = "the standard error is %.3g after %d rays a pixel, above --max-stderr %g; raise --spp"
        log.warning(words, found.noise, found.spp, limit)
    return found


def _summary(scene: Scene, found: Truth) -> str:
    h, w = found.visibility.shape
    speed = f"{found.rays / 1e6:.1f} million rays in {found.seconds:.1f} s" + (", from the cache" if found.cached else "")
    return (
        f"{scene.name}, {scene.contents}, {w}x{h}, {found.tracing.falloff} radius {found.tracing.radius:.4g},"
        f" {found.spp} rays a pixel, standard error {found.noise:.2g}, {speed}"
    )


def _picture(found: Truth, **report: object) -> Picture:
    """Return visibility, standard error and depth as a picture, to be saved."""
    table = {name: getattr(found.tracing, name) for name in ("radius", "falloff", "normals", "max_stderr", "seed")}
    arrays = {"visibility": found.visibility, "stderr": found.stderr, "depth": found.depth}
    size = list(found.visibility.shape[::-1])
    return Picture(arrays, {"settings": {"truth": table | {"spp": found.spp}}, "size": size, **report})


def _numbers(scene: Scene, found: Truth) -> dict[str, object]:
    covered = found.visibility[found.covered]
    return {
        "triangles": scene.triangles,
        **_picture(found).report,
        "stderr": found.noise,
        "rays": found.rays,
        "seconds": found.seconds,
        "cached": found.cached,
        "covered": float(found.covered.mean()),
        "mean_visibility": float(covered.mean()) if covered.size else None,
    }
