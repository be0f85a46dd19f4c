"""Failing inputs on the disk: written when a case fails, drawn again from there.

A folder holds ``case.json`` (case, method, settings, what failed) and, for each shot, its depth, its normals if it has any
(NPY, row 0 on top) and its camera (in ``case.json``, a 4x4 projection for OpenGL's clip range).
"""

from __future__ import annotations

import dataclasses
import json
import re
import shlex
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError, SsaoError
from ..io import images
from ..io.atomic import atomic_write, make_folder, why_unreadable
from ..methods.registry import method
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.projection import Size
from ..settings import as_table, assign
from .case import Case
from .catalogue import cases
from .fuzz import PREFIX
from .reduce import smaller
from .runner import Broken, CaseRunner
from .shot import Shot
from .specimen import Specimen
from .verdicts import CaseResult, Failure, judged

CASE = "case.json"

KEPT = 3
"""Failures of one kind that are reduced and written; of more there is nothing to learn."""


@dataclass
class Recorder:
    """Writes failures below a folder, each reduced as far as it goes. ``seed`` of the random cases."""

    renderer: Renderer
    folder: Path
    seed: int
    kinds: Counter[tuple[str, str]] = field(default_factory=Counter)

    def __call__(self, failure: Failure) -> CaseResult:
        """Write a failure down; the row with its folder and the command that replays it. Raises FormatError."""
        row = failure.row
        kind = row.method, re.sub(r"\d+", "", row.reason)
        self.kinds[kind] += 1
        if self.kinds[kind] > KEPT:
            return dataclasses.replace(row, command=self._by_name(failure))
        place = self.folder / "-".join((row.case, row.method, *([row.preset] * (row.preset != "default")), row.provider))
        make_folder(place)
        shot = self._reduced(failure)
        drawn = [shot] if shot else list(failure.shots)
        content = {
            **{key: getattr(row, key) for key in ("case", "method", "preset", "provider", "reason", "measured", "bound")},
            "settings": as_table(failure.subject.method),
            "precision": failure.subject.precision,
            "whole": shot is None,
            "original": self._by_name(failure),
            "shots": [_write_shot(place, number, one) for number, one in enumerate(drawn, 1)],
        }
        with atomic_write(place / CASE) as temporary:
            temporary.write_text(json.dumps(content, indent=1) + "\n", "utf-8")
        command = (
            self._by_name(failure)
            if shot is None
            else shlex.join(["ssao-gl", "stress", "--gl", row.provider, "--replay", str(place)])
        )
        return dataclasses.replace(row, folder=str(place), command=command)

    def _by_name(self, failure: Failure) -> str:
        row, precision = failure.row, failure.subject.precision
        words = ["ssao-gl", "stress", "--gl", row.provider, "--methods", row.method, "--only", row.case]
        words += ["--presets", row.preset] if row.preset != "default" else []
        words += ["--precision", precision] if precision != "high" else []
        return shlex.join(words + (["--seed", str(self.seed)] if row.case.startswith(PREFIX) else []))

    def _reduced(self, failure: Failure) -> Shot | None:
        """Return the smallest depth image that breaks a promise; None where it takes the whole case to show the failure."""
        lab = CaseRunner(self.renderer, failure.subject)

        def fails(shot: Shot) -> bool:
            try:
                lab.see(shot)
            except Broken:
                return True
            except Exception:  # what fails in another way is another failure
                return False
            return False

        shot = failure.broken
        if shot is None or (shot.scene is not None and (shot := _as_depth(self.renderer, failure, shot)) is None):
            return None
        return smaller(shot, fails) if fails(shot) else None


def _as_depth(renderer: Renderer, failure: Failure, shot: Shot) -> Shot | None:
    """Return a scene's picture as a depth image with normals, under the same projection."""
    assert shot.scene is not None and shot.size is not None
    try:
        seen = renderer.render(shot.scene, shot.camera, shot.size, failure.subject.settings(shot), aovs=("depth", "normal"))
    except SsaoError:
        return None
    camera = Camera.from_matrix(shot.camera.view(shot.size).projection)
    return shot.but(scene=None, camera=camera, depth=seen.depth, normals=seen.normal)


def _write_shot(place: Path, number: int, shot: Shot) -> dict[str, Any]:
    """Arrays to files, all the rest as plain values."""
    arrays = {"depth": shot.depth, "normals": shot.normals}
    files = {name: f"{number}-{name}.npy" for name, array in arrays.items() if array is not None}
    for name, file in files.items():
        images.save_image(place / file, np.asarray(arrays[name]))
    size = shot.size or (1, 1)
    return {
        **files,
        "scene": None if shot.scene is None else shot.scene.name or shot.scene.contents,
        "size": list(size),
        "projection": _projection(shot.camera, size),
        "pose": np.asarray(shot.camera.pose).tolist(),
        **{key: getattr(shot, key) for key in ("kind", "radius", "blur", "normals_of")},
        "keep": list(shot.keep),
        "changes": dict(shot.changes),
    }


def _projection(camera: Camera, size: Size) -> list[list[float]] | None:
    """Return the camera's matrix (4, 4); None where having none is what failed."""
    try:
        found: list[list[float]] = camera.view(size).projection.tolist()
        return found
    except (SsaoError, ArithmeticError):
        return None


def replayed(renderer: Renderer, folder: Path) -> CaseResult:
    """Draw a written failure again, and judge it. Raises FormatError for a folder that holds none."""
    content = _read(folder)
    try:
        record = assign(method(content["method"]), content["settings"])
        subject = Specimen(content["method"], content["preset"], record, content.get("precision", "high"))
        if content["whole"]:
            case = cases()[content["case"]]
        else:
            shot = _read_shot(folder, content["shots"][0])
            case = _as_case(content["case"], shot)
    except (KeyError, TypeError, IndexError, AttributeError, ValueError) as error:
        raise FormatError(f"{folder / CASE}: not what ssao-gl stress writes ({type(error).__name__}: {error})") from None
    return judged(case, CaseRunner(renderer, subject))[0]


def _as_case(name: str, shot: Shot) -> Case:
    def measure(lab: CaseRunner) -> float:
        lab.see(shot)
        return 0.0

    return Case(name, "replayed", "the picture keeps what every picture promises", "0", 0.0, measure)


def _read(folder: Path) -> dict[str, Any]:
    path = folder / CASE
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected a folder that ssao-gl stress wrote for a failure")
    try:
        content = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: not JSON ({error})") from None
    if not isinstance(content, dict):
        raise FormatError(f"{path}: expected an object")
    return content


def _read_shot(folder: Path, entry: dict[str, Any]) -> Shot:
    arrays: dict[str, Any] = {
        name: images.load_image(folder / str(entry[name])) for name in ("depth", "normals") if name in entry
    }
    return Shot(
        Camera.from_matrix(entry["projection"]),
        **arrays,
        **{key: entry[key] for key in ("kind", "radius", "blur", "normals_of", "changes")},
        keep=tuple(entry.get("keep", ())),
    )
