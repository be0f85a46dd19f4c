"""What a render gives back: arrays, and how they came about."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, near_miss, one_line
from ..io import images
from ..io.atomic import atomic_write, is_folder, locked_folder, make_folder
from ..io.streams import output_suffix
from ..pipeline.outputs import MASKS


@dataclass(frozen=True, eq=False, repr=False)
class Picture:
    """The arrays that were asked for, row 0 on top, and a report of how they were made.

    image: (h, w, 3) uint8 sRGB, or (h, w, 4) when the background is transparent, or the caller's colour had alpha. visibility: (h, w) float32, 1 = open,
    background exactly 1, of half floats or of 8 bits. depth: (h, w) float32, distance along the view axis in scene units, 0 = background. normal:
    (h, w, 3) float32, unit, view space, (0, 0, 0) on background. bent: (h, w, 3) float32, the same of the mean of the open
    directions by their cosines. color: (h, w, 3) uint8 sRGB base colour. object, instance, material: (h, w) uint32, the number of
    what is seen, from 1, 0 on background; ``report["labels"]`` has the names.
    """

    arrays: Mapping[str, NDArray[Any]]
    report: Mapping[str, Any] = field(default_factory=dict)

    def __getattr__(self, name: str) -> NDArray[Any]:
        from ..pipeline.outputs import AOVS

        arrays = self.__dict__.get("arrays", {})
        if name in arrays:
            return np.asarray(arrays[name])
        if name in AOVS:
            raise AttributeError(f"this picture has no '{name}'; ask for it: aovs=({', '.join(map(repr, [*arrays, name]))})")
        if name.startswith("_"):  # what libraries look for
            raise AttributeError(name)
        known = [*arrays, "report", "save", "as_png", "texts"]
        raise AttributeError(f"a picture has no '{name}'; this one has {', '.join(known)}.{near_miss(name, known)}")

    @property
    def texts(self) -> dict[str, str]:
        """What PNG files carry: how the picture was made. Times are left out, so equal pictures are equal files."""
        return metadata_text(self.report)

    def save(self, path: Path | str, *, aov: str | None = None, bits: int = 8) -> list[Path]:
        """Write one AOV to a file by suffix (PNG, NPY, EXR), or all of them into a folder, each as NPY and as PNG.

        Without ``aov`` a PNG gets the image, an array file the visibility. ``bits``: 8 or 16, of grey PNG files.
        Returns the paths written. Raises FormatError.
        """
        path = Path(path)
        suffix = output_suffix(path)
        if suffix in images.SUFFIXES and not is_folder(path):
            default = "image" if suffix == ".png" else "visibility"
            name = aov or (default if default in self.arrays else next(iter(self.arrays)))
            if name not in self.arrays:
                raise FormatError(f"this picture has no '{name}'; it has {', '.join(self.arrays)}")
            images.save_image(path, self.as_png(name, bits) if suffix == ".png" else self.arrays[name], texts=self.texts)
            return [path]
        if path.suffix and not is_folder(path):
            raise FormatError(f"cannot write {path}: suffix '{path.suffix}'; use {', '.join(images.SUFFIXES)}, or a folder")
        make_folder(path)
        done = []
        with locked_folder(path):
            for name, array in self.arrays.items():
                images.save_image(path / f"{name}.npy", array)
                images.save_image(path / f"{name}.png", self.as_png(name, bits), texts=self.texts)
                done += [path / f"{name}.npy", path / f"{name}.png"]
        return done

    def as_png(self, name: str, bits: int = 8) -> NDArray[Any]:
        """Return an AOV as PNG shows it.

        Visibility as grey, depth from near (bright) to far (dark) with background black, normals as 0.5 + 0.5 n, masks as their
        numbers in 16 bits.
        """
        array = self.arrays[name]
        return to_png_array(name, array, bits, depth_span(array) if name == "depth" else None)

    def __repr__(self) -> str:
        h, w = next(iter(self.arrays.values())).shape[:2] if self.arrays else (0, 0)
        facts = [self.report.get(key) for key in ("scene", "provider")]
        method = self.report.get("settings", {}).get("method")
        about = "".join(f", {one_line(fact, 60)}" for fact in (method, *facts) if fact)
        return f"<Picture {w}x{h}: {', '.join(self.arrays) or 'nothing'}{about}>"

    def _repr_html_(self) -> str:
        from .picture_html import picture_html

        return picture_html(self)

    def _repr_png_(self) -> bytes:
        name = "image" if "image" in self.arrays else next(iter(self.arrays))
        return images.png_bytes(self.as_png(name))


def depth_span(depth: NDArray[Any]) -> tuple[float, float] | None:
    """Nearest and farthest of linear depths that are not background; None when all are."""
    seen = depth[depth > 0]
    return (float(seen.min()), float(seen.max())) if seen.size else None


def to_png_array(name: str, array: NDArray[Any], bits: int = 8, span: tuple[float, float] | None = None) -> NDArray[Any]:
    """Return the values of an AOV, or of some of its rows, as :meth:`Picture.as_png` says. ``span``: :func:`depth_span` of
    all rows."""
    if name == "visibility":
        return images.to_bytes(array, bits)
    if name == "depth":
        near, far = span or (0.0, 0.0)
        shade = 1 - 0.95 * (array - near) / max(far - near, 1e-30)
        return images.to_bytes(np.where(array > 0, shade, 0), bits)
    if name in ("normal", "bent"):
        return images.to_bytes(np.where(np.any(array, axis=-1, keepdims=True), 0.5 + 0.5 * array, 0))
    if name in MASKS:
        return mask_png(name, array)
    return array


def mask_png(name: str, array: NDArray[Any]) -> NDArray[np.uint16]:
    """Return a mask as 16-bit grey, each number as it is. Raises FormatError for numbers beyond."""
    if array.size and int(array.max()) > np.iinfo(np.uint16).max:
        raise FormatError(f"{name}: numbers up to {int(array.max())} do not fit into a PNG of 16 bits; write .npy")
    return array.astype(np.uint16)


def save_animation(path: Path, frames: Sequence[Picture], *, seconds: float = 4.0) -> None:
    """Write the first AOV of each picture as an animation; see :func:`save_frames`."""
    save_frames(path, [frame.as_png(next(iter(frame.arrays))) for frame in frames], seconds=seconds)


def save_frames(path: Path, frames: Sequence[NDArray[Any]], *, seconds: float = 4.0) -> None:
    """Write frames (h, w) or (h, w, 3 or 4) uint8 as an animated GIF, WebP or PNG by suffix (``.gif``, ``.webp``, ``.apng``).

    Raises FormatError.
    """
    from PIL import Image

    kinds = {".gif": "GIF", ".webp": "WEBP", ".apng": "PNG"}
    first, *rest = map(Image.fromarray, frames)
    step = max(20, round(1000 * seconds / len(frames)))
    with atomic_write(path) as temporary:
        first.save(temporary, format=kinds[path.suffix.lower()], save_all=True, append_images=rest, duration=step, loop=0)


def metadata_text(report: Mapping[str, Any]) -> dict[str, str]:
    """Return the part of a report that goes into PNG files, by the keys of its text chunks."""
    keys = ("settings", "camera", "size", "scene", "provider", "renderer", "version")
    return {"Software": "ssao_gl", **{f"ssao_gl:{key}": _plain(report[key]) for key in keys if key in report}}


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True)
