"""``ssao-gl bake``: ambient occlusion that a file can keep."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ..bake import Baked, Baking
from ..bake import bake as baked
from ..bake.settings import BY, KERNELS, SIDES, UNWRAP, OcclusionTexture, Vertices
from ..errors import SceneError, SettingsError
from ..sampling.falloff import Falloff
from ..settings import as_table
from .cache_options import CacheOptions
from .help_pages import OUTPUT, RARE, RAYS
from .output import check_json, check_output, counted, own_length, say, write_json
from .signals import Terminated
from .tokens import WHOLE, parse_share


@Parameter(name="*", group=RAYS)
@dataclass(frozen=True, kw_only=True)
class BakedRayOptions:
    """What measures: which rays, and how many, or elements."""

    by: Annotated[
        str, Parameter(help=f"What measures: {' or '.join(BY)}, disks that stand for the triangles (faster, less exact).")
    ] = BY[0]
    radius: Annotated[
        str | None,
        Parameter(
            help="Reach of occlusion in scene units, or a share of the scene's size, like 10%. [default: 3%]",
            allow_leading_hyphen=True,
        ),
    ] = None
    spp: Annotated[int, WHOLE, Parameter(help="Rays a vertex or texel, rounded up to a power of two.")] = 64
    falloff: Annotated[str, Parameter(help=f"How a blocker counts with distance: {', '.join(Falloff)}.")] = Falloff.HARD.value
    sides: Annotated[
        str,
        Parameter(
            help=f"Side that counts: {', '.join(SIDES)}. Both: the more open one; auto: both where the material is double-sided.",
        ),
    ] = SIDES[0]
    points: Annotated[
        int, WHOLE, Parameter(group=RARE, help="Points around a vertex, on its triangles, that share its rays.")
    ] = 16
    seed: Annotated[int, WHOLE, Parameter(group=RARE, help="Of points and directions.")] = 0
    passes: Annotated[
        int, WHOLE, Parameter(group=RARE, help="Of elements, against shadows counted twice; the last two are averaged.")
    ] = 4
    indirect: Annotated[
        bool,
        Parameter(
            group=RARE, negative="", help="Of elements: add the light that they send each other, in their colours, to COLOR_0."
        ),
    ] = False
    kernel: Annotated[
        str, Parameter(group=RARE, help=f"What a disk takes: {' or '.join(KERNELS)}, the formula of GPU Gems 2.")
    ] = KERNELS[0]

    def baking(self) -> Baking:
        """Return the settings of the rays; a radius that is a share comes later. Raises SettingsError."""
        given: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        return Baking(**{**given, "radius": own_length(self.radius)})


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class KeptOptions:
    """How occlusion is kept in the file."""

    to: Annotated[Literal["vertices", "texture"], Parameter(help="Where occlusion goes.")] = "vertices"
    attribute: Annotated[
        str, Parameter(help="Of vertices: COLOR_0, whose colours are multiplied, or a name of your own, like _AO.")
    ] = "COLOR_0"
    size: Annotated[int, WHOLE, Parameter(help="Width and height of a texture, texels.")] = 1024
    padding: Annotated[int, WHOLE, Parameter(help="Texels between charts, where texture coordinates are made.")] = 4
    unwrap: Annotated[
        str,
        Parameter(
            help=f"Make texture coordinates: {', '.join(UNWRAP)}. Auto: where there are none in 0..1 that do not overlap."
        ),
    ] = UNWRAP[0]
    per_instance: Annotated[
        bool,
        Parameter(negative="", help="Give each node a mesh of its own; else nodes that show one share their mean."),
    ] = False

    def goal(self) -> Vertices | OcclusionTexture:
        """Return what is made. Raises SettingsError for what is no option of it."""
        to = self.to
        texture = ("size", "padding", "unwrap")
        given = {name: getattr(self, name) for name in ("attribute", *texture)}
        own = ("attribute",) if to == "vertices" else texture
        default = KeptOptions()
        for name, value in given.items():
            if name not in own and value != getattr(default, name):
                other = "texture" if to == "vertices" else "vertices"
                raise SettingsError(f"--{name} {value}: is for --to {other}")
        found = {name: given[name] for name in own}
        return Vertices(**found) if to == "vertices" else OcclusionTexture(**found)


@Parameter(name="*", group=RARE)
@dataclass(frozen=True, kw_only=True)
class PoseOptions:
    """What is read of the scene file."""

    animation: Annotated[
        str | None, Parameter(help="Pose of a glTF file: an animation, by name or number. [default: the rest pose]")
    ] = None
    time: Annotated[float, Parameter(allow_leading_hyphen=True, help="Moment of --animation, seconds.")] = 0.0
    strict: Annotated[bool, Parameter(negative="", help="Take it for an error when something is dropped or guessed.")] = False

    def check(self) -> None:
        """Raise SettingsError for a moment without an animation."""
        if self.time and self.animation is None:
            raise SettingsError(f"--time {self.time:g}: is the moment of an animation; add --animation NAME")


def bake(
    scene: Path,
    *,
    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            allow_leading_hyphen=True,
            help="GLB file, - for standard output, or a folder for visibility as NPY, a file for each mesh.",
        ),
    ],
    kept: KeptOptions = KeptOptions(),
    rays: BakedRayOptions = BakedRayOptions(),
    pose: PoseOptions = PoseOptions(),
    cache: CacheOptions = CacheOptions(),
    json: Annotated[
        Path | None,
        Parameter(
            group=OUTPUT,
            negative="",
            allow_leading_hyphen=True,
            help="Write settings, meshes, rays and seconds to this file; - prints them.",
        ),
    ] = None,
) -> int:
    """Trace ambient occlusion into the vertices or textures of a GLB file.

    Parameters
    ----------
    scene
        Scene file. Of a GLB or glTF file all else is kept; others are written as GLB.
    """
    check_output("-o", output, (".glb",), folder=True)
    check_json(json)
    found = _baked(scene, kept, rays, pose, cache.folder())
    paths = found.save(output)
    where = str(paths[0]) if len(paths) == 1 else f"{output} ({len(paths)} files)"
    say(f"{where}: {_summary(found)}")
    if json:
        write_json(json, _numbers(found))
    return 0


def _baked(scene: Path, kept: KeptOptions, rays: BakedRayOptions, pose: PoseOptions, cache: Path | None) -> Baked:
    """Bake, with a progress bar; say so when it is cut."""
    settings, goal = rays.baking(), kept.goal()
    pose.check()
    with counted("tracing") as progress:
        try:
            found = baked(
                scene, settings, radius_share=parse_share(rays.radius or ""), to=goal, per_instance=kept.per_instance,
                animation=pose.animation, time=pose.time, cache=cache, progress=progress,
            )  # fmt: skip
        except (KeyboardInterrupt, Terminated) as error:
            if cache is not None:
                error.add_note("what is traced so far is kept; the same command goes on from there")
            raise
    if pose.strict and found.warnings:
        raise SceneError(f"{scene}: {found.warnings[0]} (--strict)")
    return found


def _summary(found: Baked) -> str:
    speed = f"{found.rays / 1e6:.1f} million rays in {found.seconds:.1f} s" + (", from the cache" if found.cached else "")
    places = sum(mesh.visibility.size for mesh in found.meshes)
    what = f"{len(found.meshes)} mesh{'es' if len(found.meshes) > 1 else ''}, {places:,} vertices"
    if isinstance(found.to, OcclusionTexture):
        what = f"{len(found.meshes)} texture{'s' if len(found.meshes) > 1 else ''} of {found.to.size}x{found.to.size}"
    reach = f"{found.settings.falloff} radius {found.settings.radius:.4g}"
    if found.settings.by == "elements":
        return f"{found.name}, {what}, {reach}, by elements, {found.settings.passes} passes, {found.seconds:.1f} s"
    return f"{found.name}, {what}, {reach}, {found.settings.spp} rays each, {speed}"


def _numbers(found: Baked) -> dict[str, Any]:
    kind = found.to.name
    return {
        "scene": found.name,
        "settings": {"bake": as_table(found.settings), kind: as_table(found.to)},
        "meshes" if kind == "vertices" else "textures": [
            {"name": mesh.name, kind: mesh.visibility.size, "mean_visibility": float(mesh.visibility.mean())}
            for mesh in found.meshes
        ],
        "rays": found.rays,
        "seconds": found.seconds,
        "cached": found.cached,
        "warnings": list(found.warnings),
    }
