"""Lists of what to draw: JSON lines, CSV or Parquet, a row for each scene with its cameras, size and settings."""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import SettingsError, SsaoError, near_miss, one_line
from ..io.atomic import why_unreadable
from ..pipeline.presets import as_rays, settings_from
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from .request import Request

SUFFIXES = (".jsonl", ".csv", ".parquet")
LOOK = ("method", "preset", "blur", "radius", "rays", "set")
AROUND = ("distance", "keep_away", "seed")
COLUMNS = ("scene", "camera", "size", "aov", *AROUND, *LOOK)
RowValues = Mapping[str, Any]


def read_manifest(path: Path, request: Request) -> Iterator[tuple[Path, Request]]:
    """Yield (scene, request) for each row; what a row leaves out is as in ``request``.

    Columns: scene (relative to the manifest), camera (a word as of ``--cameras``, or, in JSON lines, an entry of a camera file),
    size (640x360), aov, distance, keep_away, seed, method, preset, blur, radius (scene units or 5%), rays, set (``key=value``, several
    by ``;``). Raises SettingsError, with the number of the row.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise SettingsError(f"{path}: suffix '{path.suffix}'; a manifest is one of {', '.join(SUFFIXES)}")
    if reason := why_unreadable(path):
        raise SettingsError(f"{path}: {reason}; expected a manifest")
    for number, values in enumerate(_rows(path), 1):
        try:
            yield _request(values, path.parent, request)
        except SettingsError as error:
            raise SettingsError(f"{path}: row {number}: {error}") from None
        except (TypeError, ValueError) as error:
            raise SettingsError(f"{path}: row {number}: {one_line(error)}") from None


def _rows(path: Path) -> Iterator[RowValues]:
    readers: Mapping[str, Callable[[Path], Iterator[RowValues]]] = {".jsonl": _lines, ".csv": _csv, ".parquet": _parquet}
    try:
        yield from readers[path.suffix.lower()](path)
    except SsaoError:
        raise
    except (OSError, ValueError, csv.Error, RecursionError) as error:
        raise SettingsError(f"{path}: cannot be read ({one_line(error, 160)})") from None


def _lines(path: Path) -> Iterator[RowValues]:
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if not line.strip():
                continue
            try:
                row = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise SettingsError(f"{path}: line {number}: not JSON ({one_line(error, 120)})") from None
            if not isinstance(row, dict):
                raise SettingsError(f'{path}: line {number}: expected an object, like {{"scene": "a.glb"}}')
            yield row


def _csv(path: Path) -> Iterator[RowValues]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        for row in csv.DictReader(file, strict=True):
            if None in row or None in row.values():
                raise SettingsError(f"{path}: a row has other columns than the header")
            yield row


def _parquet(path: Path) -> Iterator[RowValues]:
    try:
        from pyarrow import parquet
    except ImportError:
        try:
            import polars
        except ImportError:
            raise SettingsError(f"{path}: Parquet needs the package pyarrow or polars: pip install pyarrow") from None
        yield from polars.read_parquet(path).iter_rows(named=True)
        return
    yield from parquet.read_table(path).to_pylist()


def _request(values: RowValues, folder: Path, base: Request) -> tuple[Path, Request]:
    given = {key: value for key, value in values.items() if value not in (None, "")}
    for key in given:
        if key not in COLUMNS:
            raise SettingsError(f"unknown column '{key}'; there are {', '.join(COLUMNS)}.{near_miss(key, COLUMNS)}")
    if "scene" not in given:
        raise SettingsError("lacks 'scene'")
    changes: dict[str, Any] = {}
    if "size" in given:
        changes["size"] = _size(given["size"])
    if "aov" in given:
        changes["aovs"] = given["aov"]
    around: dict[str, Any] = {key: (int if key == "seed" else float)(given[key]) for key in AROUND if key in given}
    if around:
        changes["around"] = dataclasses.replace(base.around, **around)
    if "camera" in given:
        changes["cameras"] = _cameras(given["camera"], folder)
    look = {key: given[key] for key in LOOK if key in given}
    if look:
        changes["settings"], changes["share"] = _settings(look, base)
    return folder / str(given["scene"]), dataclasses.replace(base, **changes)


def _cameras(value: Any, folder: Path) -> str | Camera:
    """Return a camera of JSON lines, or the word of a generator or file, which is looked for beside the manifest."""
    if isinstance(value, dict):
        return Camera.from_json(value)
    word = str(value)
    kind, colon, rest = word.partition(":")
    if kind == "path" and colon:
        return f"path:{folder / rest}"
    return word if kind in ("orbit", "sphere", "own") else str(folder / word)


def _size(value: Any) -> Any:
    if isinstance(value, str):
        w, _, h = value.lower().partition("x")
        if not (w.strip().isdigit() and h.strip().isdigit()):
            raise SettingsError(f"size '{value}': must be WIDTHxHEIGHT, like 640x360")
        return int(w), int(h)
    return value


def _settings(look: RowValues, base: Request) -> tuple[Settings, float | None]:
    """Return settings and the share that the radius is: a row's over the base's, whose method stays unless the row names one or a preset."""
    table = _told(base.settings.table())
    if "method" in look or "preset" in look:
        table.pop(base.settings.method.name, None)
    words = look.get("set", ())
    assignments = words.split(";") if isinstance(words, str) else [f"{key}={value}" for key, value in dict(words).items()]
    radius = str(look.get("radius", ""))
    share = float(radius[:-1]) / 100 if radius.endswith("%") else None
    if radius:
        assignments = [*assignments, f"radius={'auto' if share is not None else radius}"]
    settings = settings_from(
        table,
        method_name=look.get("method"),
        preset_name=look.get("preset"),
        blur_name=look.get("blur"),
        assignments=[word.strip() for word in assignments if word.strip()],
        rays=as_rays(str(look["rays"])) if "rays" in look else None,
    )
    return settings, share if radius else base.share


def _told(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table of settings without what is automatic."""
    return {key: _told(v) if isinstance(v, Mapping) else v for key, v in values.items() if v is not None}
