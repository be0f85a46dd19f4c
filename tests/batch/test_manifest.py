"""Manifests: three formats say the same; what is wrong is told with its row."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

import ssao_gl as ao
from ssao_gl.batch.manifest import read_manifest
from ssao_gl.batch.request import Request
from ssao_gl.scene.camera import Camera

ROWS: list[dict[str, Any]] = [
    {"scene": "a.obj", "camera": "orbit:3", "size": "64x48", "aov": "depth", "seed": 3},
    {"scene": "sub/b.obj", "method": "alchemy", "radius": "5%", "set": "samples=4;blur.radius=2"},
    {"scene": "c.obj", "radius": "0.25", "preset": "high", "camera": "c.cam.json:front"},
]


def written(path: Path) -> Path:
    keys = list(dict.fromkeys(key for row in ROWS for key in row))
    if path.suffix == ".jsonl":
        path.write_text("".join(json.dumps(row) + "\n\n" for row in ROWS))
    elif path.suffix == ".csv":
        with path.open("w", newline="") as file:
            table = csv.DictWriter(file, keys, restval="")
            table.writeheader()
            table.writerows(ROWS)
    else:
        import pyarrow
        from pyarrow import parquet

        parquet.write_table(pyarrow.table({key: [row.get(key) for row in ROWS] for key in keys}), path)
    return path


@pytest.mark.parametrize("suffix", [".jsonl", ".csv", ".parquet"])
def test_a_row_says_what_is_its_own(suffix: str, tmp_path: Path) -> None:
    base = Request(size=(8, 8), cameras="sphere:2", settings=ao.Settings(method=ao.Bitmask(slices=3)))
    (s1, r1), (s2, r2), (s3, r3) = read_manifest(written(tmp_path / f"m{suffix}"), base)
    assert (s1, s2, s3) == (tmp_path / "a.obj", tmp_path / "sub/b.obj", tmp_path / "c.obj")
    assert (r1.cameras, r1.size, r1.aovs, r1.around.seed, r1.settings) == ("orbit:3", (64, 48), ("depth",), 3, base.settings)
    assert (r2.cameras, r2.size, r2.share, r2.settings.method.name) == ("sphere:2", (8, 8), 0.05, "alchemy")
    assert (r2.settings.method.samples, r2.settings.blur.radius, r2.settings.method.radius) == (4, 2, None)  # type: ignore[attr-defined, union-attr]
    assert r3.cameras == str(tmp_path / "c.cam.json:front")
    assert (r3.settings.method.radius, r3.share) == (0.25, None)
    assert r3.settings.method.layers == 2, "the preset is not hidden by the base's own settings"  # type: ignore[attr-defined]


def test_a_line_may_hold_a_camera(tmp_path: Path) -> None:
    camera = Camera.perspective(0.7, 0.1, 20).named("mine")
    (tmp_path / "m.jsonl").write_text(json.dumps({"scene": "a.obj", "camera": json.loads(camera.to_json())}))
    ((_, request),) = read_manifest(tmp_path / "m.jsonl", Request())
    assert isinstance(request.cameras, Camera) and request.cameras.name == "mine"


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("m.jsonl", '{"scene": "a"}\n{"scene": 1', "line 2"),
        ("m.jsonl", "[1]", "line 1"),
        ("m.jsonl", '{"camera": "orbit:2"}', "row 1: lacks 'scene'"),
        ("m.jsonl", '{"scene": "a", "methid": "gtao"}', "Did you mean 'method'"),
        ("m.jsonl", '{"scene": "a", "size": "big"}', "row 1: size"),
        ("m.jsonl", '{"scene": "a", "radius": "wide"}', "row 1"),
        ("m.csv", "scene,size\na.obj,8x8,9\n", "columns"),
        ("m.csv", "scene,seed\na.obj,x\n", "row 1"),
        ("m.parquet", "PAR1 nothing", "cannot be read"),
        ("m.txt", "a", "suffix"),
        ("gone.csv", None, "no such file"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(name: str, text: str | None, told: str, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(ao.SettingsError, match=told) as error:
        list(read_manifest(tmp_path / name, Request()))
    assert "\n" not in str(error.value) and name in str(error.value)
