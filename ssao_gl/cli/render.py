"""``ssao-gl render``: a scene to pictures."""

from __future__ import annotations

import dataclasses
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .. import planner
from ..errors import FormatError, SettingsError
from ..io import images
from ..io.atomic import is_folder
from ..io.streams import output_suffix
from ..pipeline.outputs import AOVS, aov_names
from ..pipeline.settings import Settings
from ..planner import Target
from ..render.picture import Picture
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..scene.screen_bounds import unseen
from ..tiling.job import Job
from ..tiling.layout import layout
from ..tiling.turntable import ANIMATIONS, Turntable, draw_turntable
from .help_pages import OUTPUT, RARE
from .options import GlOption, JsonOption, LitLookOptions, ViewOptions
from .output import check_json, check_output, input_warnings, progress, say, write_json
from .plan_options import PlanOptions, compared, drawn_at_once, expected
from .signals import Terminated
from .tile_options import TileOption, draw_tiles, rendered_line
from .tokens import WHOLE

TIMED_FRAMES = 5


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class PictureOptions:
    """What is written, and where."""

    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            allow_leading_hyphen=True,
            help="PNG, NPY or EXR file, - for a PNG on standard output, or a folder for all AOVs as NPY and PNG.",
        ),
    ] = Path("ssao.png")
    background: Annotated[
        str | None,
        Parameter(
            help="Behind the scene in the image: #rrggbb, white, black or transparent (RGBA). [default: the scene's, else grey blue]"
        ),
    ] = None
    aov: Annotated[
        str | None,
        Parameter(
            help=f"What to write, by commas: {', '.join(AOVS)}. [default: image for PNG, visibility for arrays, both for folders]",
        ),
    ] = None
    bits: Annotated[int, WHOLE, Parameter(group=RARE, help="Bits a pixel of grey PNG files: 8 or 16.")] = 8
    turntable: Annotated[
        int,
        WHOLE,
        Parameter(
            help="Frames of a turn about the scene: files in a folder, or one .gif, .webp or .apng.",
        ),
    ] = 0
    tile: TileOption = None
    json: JsonOption = None

    def with_background(self, settings: Settings) -> Settings:
        """Return settings with the background that was asked for. Raises SettingsError."""
        if self.background is None:
            return settings
        shading = dataclasses.replace(settings.shading, background=self.background)
        return dataclasses.replace(settings, shading=shading)

    @property
    def visibility_bits(self) -> int:
        """Bits that the visibility of one picture ends in: more for arrays than for PNG files."""
        return self.bits if output_suffix(self.output) == ".png" and not is_folder(self.output) else 16

    def aovs(self) -> tuple[str, ...]:
        """Return what is written. Raises SettingsError, FormatError for what cannot be, before anything is drawn."""
        aovs = _aovs(self.aov, self.output, self.turntable)
        _check_output(self.output, self.turntable, self.bits)
        check_json(self.json)
        if self.turntable and (self.json is not None or self.tile is not None):
            option = "--json reports on" if self.tile is None else "--tile is for"
            raise SettingsError(f"{option} one picture; leave it out with --turntable")
        return aovs


def render(
    scene: Path | None = None,
    *,
    to: PictureOptions = PictureOptions(),
    gl: GlOption = "auto",
    view: ViewOptions = ViewOptions(),
    look: LitLookOptions = LitLookOptions(),
    goal: PlanOptions = PlanOptions(),
) -> int:
    """Render a scene file with ambient occlusion.

    Parameters
    ----------
    scene
        GLB, glTF, OBJ, PLY, STL, OFF, PDB, mmCIF or another format. Without it: the embedded scene.
    """
    settings, target = to.with_background(look.settings()), goal.target(look)
    size, aovs = view.pixels(), to.aovs()
    with input_warnings(strict=False) as told:
        loaded = view.load(scene)
        settings = look.settled(settings, loaded.default_radius)
        camera = view.choose(loaded)
    if blind := unseen(loaded, camera, size):
        logging.getLogger("ssao_gl").warning("%s", blind)
    with Renderer(gl) as renderer:
        if to.turntable:
            look.dump(_turn(renderer, loaded, camera, size, settings, target, aovs, to))
            return 0
        settled = settings.settled(camera.ao_radius or loaded.default_radius(), loaded.background)
        cut = layout(loaded, camera, size, settled, aovs, tile=to.tile, limit=renderer.ctx.max_size)
        drawn_at_once(target, cut)
        if cut is not None:
            job = Job(
                scene=loaded, camera=camera, size=size, settings=settled, aovs=aovs, layout=cut, output=to.output, bits=to.bits
            )
            report = draw_tiles(renderer, job)
        else:
            timed = TIMED_FRAMES if to.json else 0
            picture = planner.render_planned(
                renderer, loaded, camera, size, target, settings,
                aovs=aovs, timed=timed, visibility_bits=to.visibility_bits,
            )  # fmt: skip
            report = dict(picture.report)
    if cut is None:
        _save(picture, to)
    look.dump(settings, report["settings"] if target else None)
    if to.json:
        told = [*told, *([blind] if blind else [])]
        write_json(to.json, {**report, "warnings": [*report.get("warnings", ()), *loaded.warnings, *told]})
    return 0


def embedded() -> int:
    """``ssao-gl`` without arguments."""
    return render()


def _aovs(text: str | None, output: Path, turntable: int) -> tuple[str, ...]:
    if text is None:
        if turntable or output_suffix(output) == ".png":
            return ("image",)
        return ("visibility",) if output_suffix(output) in images.SUFFIXES else ("image", "visibility")
    aovs = aov_names(text)  # names are checked before anything is drawn
    if len(aovs) > 1 and output_suffix(output) in images.SUFFIXES:
        raise SettingsError(f"-o {output}: one file holds one AOV; give a folder for {', '.join(aovs)}")
    return aovs


def _check_output(output: Path, turntable: int, bits: int) -> None:
    if bits not in (8, 16):
        raise SettingsError(f"--bits {bits}: must be 8 or 16")
    if turntable < 0 or turntable > 100_000:
        raise SettingsError(f"--turntable {turntable}: must be 1 to 100000 frames")
    if turntable and output_suffix(output) in images.SUFFIXES:
        raise FormatError(f"-o {output}: a turntable goes to a folder or to a {', '.join(ANIMATIONS)} file")
    check_output("-o", output, (*images.SUFFIXES, *(ANIMATIONS if turntable else ())), folder=True)


def _save(picture: Picture, to: PictureOptions) -> None:
    aov = next(iter(picture.arrays)) if len(picture.arrays) == 1 else None
    say(rendered_line(to.output, picture.save(to.output, aov=aov, bits=to.bits), picture.report))
    if "planned" in picture.report:
        say(compared(picture.report["planned"]))


def _turn(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings, target: Target | None,
    aovs: tuple[str, ...], to: PictureOptions,
) -> Settings:  # fmt: skip
    """Draw a turntable, and return the settings that it was drawn with."""
    output, count = to.output, to.turntable
    if target:
        choice = planner.plan(renderer, scene, camera, size, target, settings, aovs=aovs)
        settings = choice.settings
        say(expected(choice))
    job = Turntable(scene=scene, camera=camera, size=size, settings=settings, aovs=aovs, count=count, output=output)
    try:
        before = draw_turntable(renderer, job, lambda indices: progress(indices, "turntable", len(list(indices))))
    except (KeyboardInterrupt, Terminated) as error:
        if job.kept.exists():
            error.add_note("the frames so far are kept; the same command goes on from there")
        raise
    say(f"{output}{'' if job.animated else '/'}: {count} frames{f' ({before} from before)' if before else ''}")
    return settings
