"""A whole batch: what is asked for, what is done already, who draws the rest, and what is written of it all."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import SettingsError
from ..pipeline.settings import Settings
from .conventions import write_cameras
from .jobs import Unreadable, ViewJob, jobs_of
from .local import draw_here, draw_local
from .manifest import read_manifest
from .outputs import STORES, place_of
from .places import Place
from .request import Request
from .results import Results, gathered, write_rows, write_table
from .rows import Row, failure, is_done

Track = Callable[[Row, int, int], None]
"""Is told each row that comes, with how many have come, and how many are drawn in this run."""
WILD = "*?["


def batch(
    scenes: str | Path | Sequence[str | Path] = (),
    output: str | Path = "batch",
    *,
    cameras: str | None = None,
    manifest: str | Path | None = None,
    workers: int = 0,
    dask: str | None = None,
    settings: Settings | None = None,
    **request: Any,
) -> Results:
    """Draw many views of many scenes into a folder or store; the same call goes on where it was cut, and redoes what changed.

    scenes: files, or patterns as ``models/*.glb``. cameras: ``FILE``, ``FILE:NAME``, ``FILE:all``, ``orbit:N``, ``sphere:N``,
    ``path:FILE``, ``own``; None for one automatic view each. manifest: a JSONL, CSV or Parquet file with more rows, see
    :func:`.manifest.read_manifest`. output: a folder, a URL of fsspec, a ``.zarr``, ``.h5`` or ``.hdf5`` store. workers: processes of this machine, 0 for
    this one itself. dask: address of a scheduler, or ``local:N``. request: fields of :class:`Request`. With ``workers`` or ``dask="local:N"``, call it below
    ``if __name__ == "__main__":``.

    What cannot be drawn is told in the rows of the result, and tried again by the next call. Raises SettingsError, SceneError and FormatError
    for what concerns all, ContextError when there is no OpenGL.
    """
    asked = Request(cameras=cameras, settings=settings or Settings(), **request)
    return run(rows_of(scenes, manifest, asked), place_of(output), str(output), asked.provider, workers=workers, dask=dask)


def rows_of(
    scenes: str | Path | Sequence[str | Path], manifest: str | Path | None, request: Request
) -> list[tuple[Path, Request]]:
    """Return what is asked for as (scene, request). Raises SettingsError when that is nothing."""
    given = [scenes] if isinstance(scenes, str | Path) else scenes
    rows = [(path, request) for pattern in given for path in _matching(str(pattern))]
    if manifest is not None:
        rows += read_manifest(Path(manifest), request)
    if not rows:
        raise SettingsError("nothing to draw: name scene files, or a manifest that has rows")
    return rows


def run(
    rows: Sequence[tuple[Path, Request]], place: Place, output: str, provider: str,
    *, workers: int = 0, dask: str | None = None, begin: Callable[[int, int], None] = lambda all_, before: None,
    track: Track = lambda row, done, total: None,
) -> Results:  # fmt: skip
    """Draw what is not done; ``begin`` is told how many jobs there are and how many are done, ``track`` of each as it is drawn."""
    started = time.perf_counter()
    _check(rows, output, workers, dask)
    jobs, broken = jobs_of(rows)
    with place.claimed():
        known = gathered(place)
        done = {job.name: known[job.name] for job in jobs if is_done(place, job, known.get(job.name, {}))}
        todo = [job for job in jobs if job.name not in done]
        begin(len(jobs) + len(broken), len(done))
        # What is drawn anew is forgotten first: its old row must not stand for files that are half new.
        names = {job.name for job in jobs} | {one.name for one in broken}
        others = {name: row for name, row in known.items() if name not in names and "error" not in row}
        write_rows(place, others | done)
        lost = [failed(one) for one in broken]
        for row in lost:
            track(row, 0, len(todo))
        found = {row["name"]: row for row in lost}
        try:
            for number, row in enumerate(_drawn(todo, place, provider, workers, dask), 1):
                found[row["name"]] = row
                track(row, number, len(todo))
        finally:
            _publish(place, jobs, others, gathered(place) | found)
        place.finish()
    order = [*(one.name for one in broken), *(job.name for job in jobs)]
    every = done | found
    return Results(output, [every[name] for name in order], len(todo), len(done), time.perf_counter() - started)


def failed(one: Unreadable) -> Row:
    """Return the row of what gave no jobs."""
    return {"name": one.name, "scene": str(one.scene), "error": one.error}


def _publish(place: Place, jobs: Sequence[ViewJob], others: dict[str, Row], found: dict[str, Row]) -> None:
    """Write the table and the cameras of all that is drawn so far, also when a batch is cut."""
    order = dict.fromkeys([*others, *(job.name for job in jobs), *found])
    rows = {name: found[name] if name in found else others[name] for name in order if name in found or name in others}
    write_rows(place, rows)
    write_table(place, list(rows.values()))
    write_cameras(place, rows.values())


def _drawn(jobs: Sequence[ViewJob], place: Place, provider: str, workers: int, dask: str | None) -> Iterator[Row]:
    if not jobs:
        return
    if dask is not None:
        from .cluster import draw_on_cluster

        yield from _seen(draw_on_cluster(jobs, place, provider, dask), jobs, place)
    elif workers:
        yield from draw_local(jobs, place, provider, workers)
    else:
        yield from draw_here(jobs, place, provider)


def _seen(rows: Iterator[Row], jobs: Sequence[ViewJob], place: Place) -> Iterator[Row]:
    """Give rows on; a cluster that writes where this machine cannot look has drawn nothing."""
    named = {job.name: job for job in jobs}
    for row in rows:
        if "error" in row or is_done(place, named[row["name"]], row):
            yield row
        else:
            yield failure(
                named[row["name"]], f"drawn by {row.get('worker')}, but not to be found here; share the output's folder"
            )


def _check(rows: Sequence[tuple[Path, Request]], output: str, workers: int, dask: str | None) -> None:
    if workers < 0 or workers > 1024:
        raise SettingsError(f"workers={workers}: must be 0 to 1024 processes")
    if workers and dask is not None:
        raise SettingsError("workers and dask exclude each other: a cluster has its own workers")
    if Path(output).suffix.lower() in STORES and any(request.formats != ("auto",) for _, request in rows):
        raise SettingsError(f"-o {output}: a store has arrays as they are; leave the formats out")
    if "memory://" in output and (workers or dask is not None):
        raise SettingsError(f"-o {output}: other processes do not see this one's memory; use workers=0, or a folder")


def _matching(pattern: str) -> list[Path]:
    """Return the files of a pattern, sorted. Raises SettingsError for a pattern without any."""
    if not any(sign in pattern for sign in WILD) or Path(pattern).exists():
        return [Path(pattern)]
    root = Path(pattern).anchor
    found = sorted(path for path in Path(root).glob(pattern.removeprefix(root)) if path.is_file())
    if not found:
        raise SettingsError(f"'{pattern}': no such files")
    return found
