"""``ssao-gl render``: a scene to pictures."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .. import planner
from ..errors import FormatError, SettingsError
from ..io import images
from ..io.atomic import is_folder
from ..io.streams import output_suffix
from ..loaders.camera_files import load_cameras
from ..pipeline.outputs import AOVS, aov_names
from ..pipeline.settings import Settings
from ..planner import Target
from ..render.accumulate import accumulated
from ..render.history import History
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
            help="PNG, NPY or EXR file, - for PNG on standard output, or a folder for all AOVs as NPY and PNG.",
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
            help=f"What to write, by commas: {', '.join(AOVS)}. [default: image, visibility, or both, by the output]",
        ),
    ] = None
    bits: Annotated[int, WHOLE, Parameter(group=RARE, help="Bits a pixel of grey PNG files: 8 or 16.")] = 8
    supersample: Annotated[
        int | None,
        WHOLE,
        Parameter(group=RARE, help="Samples a pixel along each side, for smooth edges: 1, 2 or 3. [default: 1]"),
    ] = None
    turntable: Annotated[
        int,
        WHOLE,
        Parameter(
            help="Frames of a turn: folder, .gif, .webp, .apng.",
        ),
    ] = 0
    path: Annotated[
        Path | None,
        Parameter(
            group=RARE, help="Camera file whose cameras, in turn, are the frames; written as --turntable's. [default: none]"
        ),
    ] = None
    temporal: Annotated[
        bool,
        Parameter(
            group=RARE,
            negative="",
            help="Average visibility over the frames of --turntable or --path: less flicker, the same error.",
        ),
    ] = False
    accumulate: Annotated[
        int | None,
        WHOLE,
        Parameter(
            group=RARE, help="Frames whose mean the picture is, each with other noise and places in the pixels. [default: 1]"
        ),
    ] = None
    tile: TileOption = None
    json: JsonOption = None

    def settings(self, settings: Settings) -> Settings:
        """Return settings with the background and the samples that were asked for. Raises SettingsError."""
        if self.supersample is not None:
            settings = dataclasses.replace(settings, supersample=self.supersample)
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
        if self.turntable < 0 or self.turntable > 100_000:
            raise SettingsError(f"--turntable {self.turntable}: must be 1 to 100000 frames")
        aovs = _aovs(self.aov, self.output, self.frames)
        _check_output(self.output, self.frames, self.bits)
        check_json(self.json)
        if self.turntable and self.path is not None:
            raise SettingsError("--turntable and --path exclude each other: each says where the cameras stand")
        if self.temporal and not self.frames:
            raise SettingsError("--temporal is for many frames; add --turntable or --path, or use --accumulate")
        one = {"--json reports on": self.json, "--tile is for": self.tile, "--accumulate is for": self.accumulate}
        if self.frames and (found := [option for option, value in one.items() if value is not None]):
            raise SettingsError(f"{found[-1]} one picture; leave it out with {'--path' if self.path else '--turntable'}")
        if self.accumulate is not None and self.tile is not None:
            raise SettingsError("--accumulate draws a picture at once; leave --tile out")
        return aovs

    def check_at_once(self, tiles: object) -> None:
        """Raise SettingsError where frames of a picture in tiles are to be averaged."""
        if self.accumulate is not None and tiles is not None:
            raise SettingsError(
                "--accumulate is for pictures that are drawn at once, and this one would be drawn in tiles; choose a smaller --size"
            )

    def accumulated(
        self, renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings, aovs: tuple[str, ...],
        target: Target | None,
    ) -> Picture | None:  # fmt: skip
        """Return the mean of many frames where that was asked for. Raises SettingsError."""
        if self.accumulate is None:
            return None
        if target is not None:
            raise SettingsError("--accumulate takes as long as its frames; leave --budget-ms and --max-error out")

        def drawn(seen: Camera, names: Sequence[str], history: History) -> Picture:
            return renderer.render(scene, seen, size, settings, aovs=names, history=history)

        return accumulated(drawn, camera, aovs, self.accumulate)

    @property
    def frames(self) -> bool:
        """Whether there are many frames, and not one picture."""
        return bool(self.turntable) or self.path is not None


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
    settings, target = to.settings(look.settings()), goal.target(look)
    size, aovs = view.pixels(), to.aovs()
    with input_warnings(strict=False) as told:
        loaded = view.load(scene)
        settings = look.settled(settings, loaded.default_radius)
        camera = view.choose(loaded)
    if blind := unseen(loaded, camera, size):
        logging.getLogger("ssao_gl").warning("%s", blind)
    with Renderer(gl) as renderer:
        if to.frames:
            look.dump(_turn(renderer, loaded, camera, size, settings, target, aovs, to))
            return 0
        settled = settings.settled(camera.ao_radius or loaded.default_radius(), loaded.background)
        cut = layout(loaded, camera, size, settled, aovs, tile=to.tile, limit=renderer.ctx.max_size)
        drawn_at_once(target, cut)
        to.check_at_once(cut)
        if cut is not None:
            job = Job(
                scene=loaded, camera=camera, size=size, settings=settled, aovs=aovs, layout=cut, output=to.output, bits=to.bits
            )
            report = draw_tiles(renderer, job)
        else:
            timed = TIMED_FRAMES if to.json and not to.accumulate else 0
            picture = to.accumulated(renderer, loaded, camera, size, settings, aovs, target) or planner.render_planned(
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


def _aovs(text: str | None, output: Path, turntable: bool) -> tuple[str, ...]:
    if text is None:
        if turntable or output_suffix(output) == ".png":
            return ("image",)
        return ("visibility",) if output_suffix(output) in images.SUFFIXES else ("image", "visibility")
    aovs = aov_names(text)  # names are checked before anything is drawn
    if len(aovs) > 1 and output_suffix(output) in images.SUFFIXES:
        raise SettingsError(f"-o {output}: one file holds one AOV; give a folder for {', '.join(aovs)}")
    return aovs


def _check_output(output: Path, turntable: bool, bits: int) -> None:
    if bits not in (8, 16):
        raise SettingsError(f"--bits {bits}: must be 8 or 16")
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
    flight = None if to.path is None else tuple(load_cameras(to.path, size))
    output, count = to.output, to.turntable if flight is None else len(flight)
    if target:
        choice = planner.plan(renderer, scene, camera, size, target, settings, aovs=aovs)
        settings = choice.settings
        say(expected(choice))
    job = Turntable(
        scene=scene, camera=camera, size=size, settings=settings, aovs=aovs, count=count, output=output, flight=flight,
        averaged=to.temporal,
    )  # fmt: skip
    try:
        before = draw_turntable(renderer, job, lambda indices: progress(indices, "turntable", len(list(indices))))
    except (KeyboardInterrupt, Terminated) as error:
        if job.kept.exists():
            error.add_note("the frames so far are kept; the same command goes on from there")
        raise
    say(f"{output}{'' if job.animated else '/'}: {count} frames{f' ({before} from before)' if before else ''}")
    return settings
