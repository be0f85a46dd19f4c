"""A picture drawn in tiles, straight to its files: memory is that of a tile, and what was drawn survives an interruption."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..io import images
from ..io.atomic import followed, is_folder
from ..io.streams import is_stream, output_suffix, send
from ..pipeline.build import plan_render
from ..pipeline.outputs import MASKS
from ..pipeline.settings import Settings
from ..render.picture import depth_span, metadata_text, to_png_array
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from .canvas import TileCanvas, new_folder
from .identity import picture_identity
from .layout import Layout, Tile, unguarded

EXR_BYTES = 2 << 30
"""EXR files are made in memory; larger ones are refused."""

Track = Callable[[Iterable[Any], str, int], Iterable[Any]]
"""What shows progress: gives the items on, with a title and how many there are."""


def untracked(items: Iterable[Any], title: str, total: int) -> Iterable[Any]:
    """Return shows nothing."""
    return items


@dataclass(frozen=True, eq=False, kw_only=True)
class Job:
    """What is drawn in tiles, and where it goes: a PNG, NPY or EXR file (with one AOV), or a folder with each as NPY and PNG.

    The settings' radius must be settled. ``bits``: 8 or 16, of grey PNG files.
    """

    scene: Scene
    camera: Camera
    size: Size
    settings: Settings
    aovs: tuple[str, ...]
    layout: Layout
    output: Path
    bits: int = 8

    @property
    def single(self) -> bool:
        """Whether the output is one file."""
        return self.suffix in images.SUFFIXES and not is_folder(self.output)

    @property
    def suffix(self) -> str:
        """The output's suffix in small letters."""
        return output_suffix(self.output)

    @property
    def folder(self) -> Path:
        """Where the tiles are kept while it is drawn: beside the output, on the same disk; of a stream, here."""
        place = Path(self.output.name) if is_stream(self.output) else followed(self.output)
        return place.with_name(f".{place.name}.tiles") if self.single else self.output / ".tiles"

    def keeps_values(self, aov: str) -> bool:
        """Whether an AOV's own values are kept, and not only what a PNG shows of them."""
        return not self.single or self.suffix != ".png" or aov == "depth"

    @property
    def visibility_bits(self) -> int:
        """Bits that visibility ends in: more for arrays than for pictures."""
        return 16 if self.keeps_values("visibility") else self.bits

    def check(self) -> None:
        """Raise FormatError for an EXR file that does not fit into memory."""
        if self.single and self.suffix == ".exr":
            need = 4 * self.size[0] * self.size[1] * (1 if self.aovs[0] in ("visibility", "depth", *MASKS) else 3)
            if need > EXR_BYTES:
                raise FormatError(
                    f"-o {self.output}: EXR files are made in memory, and this one would take {need / 2**30:.1f} GiB (at most"
                    f" {EXR_BYTES / 2**30:.0f}); use .npy or .png, or a smaller --size"
                )

    def identity(self, renderer: Renderer) -> str:
        """Return the hash of everything that decides the pixels, and what is written of them."""
        facts = [self.aovs, [self.keeps_values(aov) for aov in self.aovs], self.bits, self.layout.table()]
        return picture_identity(renderer, self.scene, self.camera, self.size, self.settings, facts)


def draw(renderer: Renderer, job: Job, track: Track = untracked) -> tuple[list[Path], dict[str, Any]]:
    """Draw what is missing of the picture, tile by tile, and write it. Gives the paths written, and a report.

    Tiles are kept in ``job.folder`` until the picture is whole; the same job goes on where it was interrupted, be it by
    ``kill -9``, another one begins anew. The report is :attr:`Picture.report` with an entry ``tiles`` and no times of
    passes. Raises FormatError when the files cannot be written, ContextError when the driver cannot draw.
    """
    job.check()
    with (
        nullcontext() if job.single else new_folder(job.output),
        TileCanvas(job.folder, job.size, job.identity(renderer)) as mosaic,
    ):
        before = mosaic.done
        rest = job.layout.tiles()[before:]
        for tile in track(rest, "tiles", len(rest)):
            _draw_tile(renderer, job, mosaic, tile)
        report = {**mosaic.notes, "tiles": {**job.layout.table(), "from_before": before}}
        paths = _publish(job, mosaic, metadata_text(report), track)
        mosaic.remove()
    return paths, report


def _draw_tile(renderer: Renderer, job: Job, mosaic: TileCanvas, tile: Tile) -> None:
    camera = tile.camera(job.camera, job.size)
    picture = renderer.render(
        job.scene, camera, tile.outer.size, unguarded(job.settings), aovs=job.aovs, visibility_bits=job.visibility_bits
    )
    kept = {name: tile.crop(array) for name, array in picture.arrays.items()}
    spent = mosaic.notes.get("seconds", 0.0) + picture.report["seconds"]
    fine = job.visibility_bits > 8 and "visibility" in job.aovs
    plan = plan_render(job.settings, job.layout.outer, job.aovs, fine=fine)
    mosaic.notes = {
        **picture.report,
        "settings": job.settings.table(),
        "size": list(job.size),
        "plan": plan.describe().splitlines(),
        "seconds": spent,
    }
    mosaic.add(
        tile.inner,
        {name: array if job.keeps_values(name) else to_png_array(name, array, job.bits) for name, array in kept.items()},
    )


def _publish(job: Job, mosaic: TileCanvas, notes: dict[str, str], track: Track) -> list[Path]:
    """Put the finished arrays into the files that are wanted; NPY files last, since they are the arrays themselves."""
    suffixes = [job.suffix] if job.single else [".png", ".npy"]
    paths = []
    for suffix in suffixes:
        for aov in job.aovs:
            path = job.output if job.single else job.output / f"{aov}{suffix}"
            if suffix == ".npy":
                _move(mosaic.path(aov), path)
            elif suffix == ".exr":
                images.save_image(path, np.load(mosaic.path(aov)), texts=notes)
            else:
                _write_png(job, mosaic, aov, path, notes, track)
            paths.append(path)
    return sorted(paths)


def _write_png(job: Job, mosaic: TileCanvas, aov: str, path: Path, notes: dict[str, str], track: Track) -> None:
    from ..io import png_stream  # brings Pillow, which no other part needs before

    bands: Iterable[NDArray[Any]] = mosaic.bands(aov)
    if job.keeps_values(aov):
        span = _span(mosaic, aov) if aov == "depth" else None
        bands = (to_png_array(aov, band, job.bits, span) for band in bands)
    count = -(-job.size[1] // mosaic.band(aov))
    # Under a name of its own in the working folder: a process that is killed leaves nothing that the next one does not find.
    temporary = mosaic.folder / f"{aov}.png"
    try:
        with temporary.open("wb") as file:
            png_stream.write_png_rows(file, job.size, track(bands, path.name, count), notes)
    except OSError as error:
        raise FormatError(
            f"cannot write {path}: {error.strerror or error}; the tiles are kept, and the same command goes on from there"
        ) from None
    _move(temporary, path)


def _span(mosaic: TileCanvas, aov: str) -> tuple[float, float] | None:
    spans = [span for span in map(depth_span, mosaic.bands(aov)) if span]
    return (min(near for near, _ in spans), max(far for _, far in spans)) if spans else None


def _move(source: Path, path: Path) -> None:
    try:
        if is_stream(path):
            send(source, path)
        else:
            source.replace(followed(path))
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FormatError(f"cannot write {path}: {error.strerror or error}") from None
