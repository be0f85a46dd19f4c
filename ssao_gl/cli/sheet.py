"""``ssao-gl sheet``: a contact sheet of many scenes, or a thumbnail of each."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError, one_line
from ..io.atomic import atomic_write, is_folder, locked_folder, make_folder
from ..io.images import save_image
from ..io.png_stream import write_png_rows
from ..io.streams import output_suffix
from ..loaders.up_axis import AXES
from ..pipeline.settings import CALM
from ..render.renderer import Renderer
from ..tiling.contact_sheet import ContactSheet
from ..tiling.thumbnails import Thumbnail, on_ground, scene_files, thumbnails
from .help_pages import OUTPUT, RARE, VIEW
from .options import GlOption, JsonOption, LookOptions
from .output import check_json, check_output, parse_size, progress, say, write_json
from .tokens import WHOLE

TEXTS = {"Software": "ssao_gl"}


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class SheetOptions:
    """How the sheet looks, and where it goes."""

    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            allow_leading_hyphen=True,
            help="PNG file with all of them, - for standard output, or a folder for a PNG file of each.",
        ),
    ] = Path("sheet.png")
    tile: Annotated[str, Parameter(help="Width x height of each picture, pixels.")] = "256x256"
    columns: Annotated[int | None, WHOLE, Parameter(help="Pictures in a row. [default: about as many as rows]")] = None
    background: Annotated[str, Parameter(help="Behind every scene: #rrggbb, white, black or transparent.")] = CALM
    names: Annotated[bool, Parameter(negative="--no-names", help="Write the file's name below each picture.")] = True
    json: JsonOption = None

    @property
    def single(self) -> bool:
        """Whether all goes to one file."""
        return output_suffix(self.output) == ".png" and not is_folder(self.output)

    def check(self) -> None:
        """Raise SettingsError, FormatError for what cannot be, before anything is drawn."""
        if self.columns is not None and not 1 <= self.columns <= 1000:
            raise SettingsError(f"--columns {self.columns}: must be 1 to 1000")
        check_output("-o", self.output, (".png",), folder=True)
        check_json(self.json)


def sheet(
    *scenes: Path,
    to: SheetOptions = SheetOptions(),
    look: LookOptions = LookOptions(),
    up: Annotated[str, Parameter(group=VIEW, help="Axis of the files that is up: x, y, z, or auto, by format.")] = "auto",
    gl: Annotated[GlOption, Parameter(group=RARE)] = "auto",
) -> int:
    """Draw many scenes into one picture with their names, or a thumbnail of each.

    A file that cannot be drawn gets a tile that says why, and a line on standard error; the exit code is then 1.

    Parameters
    ----------
    scenes
        Files in any format of `ssao-gl render`, or folders of them.
    """
    to.check()
    if up not in ("auto", *AXES):
        raise SettingsError(f"--up {up}: must be x, y, z or auto")
    settings, size, files = on_ground(look.settings(), to.background), parse_size(to.tile, "--tile"), scene_files(scenes)
    laid = ContactSheet(count=len(files), tile=size, columns=to.columns, background=to.background, names=to.names)
    drawn: list[Thumbnail] = []
    with Renderer(gl) as renderer:
        made = thumbnails(
            renderer,
            progress(files, "sheet", len(files)),
            size,
            lambda scene: look.settled(settings, scene.default_radius),
            up=up,
        )
        tiles = _told(files, made, drawn)
        paths = _one(to.output, laid, tiles) if to.single else _each(to.output, files, tiles)
    look.dump(settings)
    broken = sum(bool(tile.fault) for tile in drawn)
    where = f"{to.output}: " if to.single else f"{to.output}{'' if str(to.output).endswith('/') else '/'}: "
    shape = f" in {laid.width_in_tiles} columns, {laid.size[0]}x{laid.size[1]}" if to.single else f", {to.tile} each"
    say(f"{where}{len(files) - broken} of {len(files)} scenes{shape}{f', {broken} could not be drawn' if broken else ''}")
    if to.json:
        write_json(to.json, [_entry(*entry) for entry in zip(files, drawn, paths, strict=True)])
    return 1 if broken else 0


def _told(files: list[Path], tiles: Iterable[Thumbnail], drawn: list[Thumbnail]) -> Iterator[Thumbnail]:
    """Yield the tiles, note each without its pixels in ``drawn``, and say what is broken."""
    for file, tile in zip(files, tiles, strict=True):
        if tile.fault:
            sys.stderr.write(f"ssao-gl: {one_line(file)}: {tile.fault}\n")
        drawn.append(dataclasses.replace(tile, image=None))
        yield tile


def _one(output: Path, laid: ContactSheet, tiles: Iterable[Thumbnail]) -> list[Path | None]:
    with atomic_write(output) as temporary, temporary.open("wb") as file:
        write_png_rows(file, laid.size, laid.bands(tiles), TEXTS)
    return [output] * laid.count


def _each(output: Path, files: list[Path], tiles: Iterable[Thumbnail]) -> list[Path | None]:
    """Write a PNG file of each scene that can be drawn, named after it; files of one name are numbered."""
    make_folder(output)
    paths: list[Path | None] = []
    taken: set[str] = set()
    with locked_folder(output):
        for file, tile in zip(files, tiles, strict=True):
            stems = (file.stem, *(f"{file.stem}-{number}" for number in range(2, len(files) + 2)))
            stem = next(stem for stem in stems if stem not in taken)
            taken.add(stem)
            paths.append(None if tile.image is None else output / f"{stem}.png")
            if tile.image is not None:
                save_image(output / f"{stem}.png", tile.image, texts=TEXTS)
    return paths


def _entry(file: Path, tile: Thumbnail, path: Path | None) -> dict[str, object]:
    fault = {"error": tile.fault} if tile.fault else {"contents": tile.contents, "warnings": list(tile.warnings)}
    return {"file": str(file), "picture": None if path is None else str(path), **fault}
