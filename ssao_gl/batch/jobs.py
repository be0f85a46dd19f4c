"""Jobs: one view of one scene each, with its inputs, its settings, where its outputs go, and the hash of all of it."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import SettingsError, SsaoError, encodable, one_line
from ..io.fingerprint import code_fingerprint
from ..pipeline.settings import Settings
from ..scene.projection import Size
from .inputs import content_digest
from .request import Request, named_like
from .views import View, views_of

LONGEST = 100


@dataclass(frozen=True, eq=False, kw_only=True)
class ViewJob:
    """A view to draw. ``files``: AOV -> its files, relative to the output. ``identity``: equal ones need not be drawn again."""

    name: str
    group: str
    index: int
    scene: Path
    view: View
    size: Size
    settings: Settings
    share: float | None
    aovs: tuple[str, ...]
    files: Mapping[str, Sequence[str]]
    provider: str
    identity: str


@dataclass(frozen=True)
class Unreadable:
    """A row that gives no jobs: its scene or its cameras cannot be read."""

    name: str
    scene: Path
    error: str


def jobs_of(rows: Iterable[tuple[Path, Request]]) -> tuple[list[ViewJob], list[Unreadable]]:
    """Return the jobs of (scene, request) pairs, grouped by scene in the order of first mention, and the rows that give none.

    Raises SettingsError when two views would have the same file.
    """
    rows = list(rows)
    groups = _groups([scene for scene, _ in rows])
    digests: dict[Path, str | SsaoError] = {}
    jobs: list[ViewJob] = []
    broken: list[Unreadable] = []
    counts: dict[Path, int] = {}
    taken: dict[str, str] = {}
    order = {scene: number for number, scene in enumerate(groups)}
    for scene, request in sorted(rows, key=lambda row: order[row[0]]):
        try:
            digest = digests.setdefault(scene, _digest(scene))
            if isinstance(digest, SsaoError):
                raise digest
            views = views_of(request.cameras, request.size, request.around, scene)
        except SettingsError:
            raise
        except SsaoError as error:
            broken.append(Unreadable(groups[scene], scene, one_line(error, 500)))
            continue
        for view in views:
            index = counts.get(scene, 0)
            counts[scene] = index + 1
            jobs.append(_job(scene, groups[scene], view, request, index, len(jobs), digest, taken))
    return jobs, list(dict.fromkeys(broken))


def _digest(scene: Path) -> str | SsaoError:
    try:
        return content_digest(scene)
    except SsaoError as error:
        return error


def _job(
    scene: Path, group: str, view: View, request: Request, index: int, number: int, digest: str, taken: dict[str, str]
) -> ViewJob:
    camera = _plain(view.name)
    name, copies = f"{group}/{camera}", 1
    while name in taken:  # two cameras of the same name
        copies += 1
        name = f"{group}/{camera}-{copies}"
    taken[name] = ""
    values: dict[str, str | int] = {"scene": group, "camera": name.removeprefix(f"{group}/"), "index": index, "number": number}
    files: dict[str, list[str]] = {}
    for aov in request.aovs:
        stem = named_like(request.names, {**values, "aov": aov})
        files[aov] = [stem + suffix for suffix in request.suffixes(aov)]
        for file in files[aov]:
            if file in taken:
                raise SettingsError(
                    f"names '{request.names}': {name} and {taken[file]} would both be {file}; let the names hold {{aov}} and more"
                )
            taken[file] = name
    facts = [
        digest, view.facts, request.size, request.settings.table(), request.share, request.aovs, files, request.provider,
        code_fingerprint(),
    ]  # fmt: skip
    identity = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:32]
    return ViewJob(
        name=name, group=group, index=index, scene=scene, view=view, size=request.size, settings=request.settings,
        share=request.share, aovs=tuple(request.aovs), files=files, provider=request.provider, identity=identity,
    )  # fmt: skip


def _plain(name: str) -> str:
    """Return a name that any file system takes."""
    plain = re.sub(r"[^\w.\-]+", "_", encodable(name)).lstrip(".")
    return plain[-LONGEST:] or "view"


def _groups(scenes: Sequence[Path]) -> dict[Path, str]:
    """Return scene -> what its files are called by: its stem, with as much of its path before it as tells it from others."""
    by_stem: dict[str, list[Path]] = {}
    for scene in dict.fromkeys(scenes):
        by_stem.setdefault(_plain(scene.stem), []).append(scene)
    named = dict.fromkeys(scenes, "")
    for stem, alike in by_stem.items():
        paths = [scene.absolute().parts for scene in alike]
        length = next((n for n in range(1, max(map(len, paths))) if len({parts[-n:] for parts in paths}) == len(alike)), None)
        for scene, parts in zip(alike, paths, strict=True):
            named[scene] = stem if len(alike) == 1 else "/".join(map(_plain, parts[-length:] if length else parts[1:]))
    return named
