"""Whatever people type, and whatever is in their files: a valid record, or an error of ours in one line. Found by Hypothesis."""

from __future__ import annotations

import dataclasses
import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ssao_gl.cli.output import check_output, parse_size, parse_vector
from ssao_gl.errors import SceneError, SettingsError, SsaoError
from ssao_gl.io.atomic import check_writable, why_unreadable
from ssao_gl.loaders.camera_files import load_camera, load_cameras
from ssao_gl.methods.registry import registry
from ssao_gl.passes.denoise import FILTERS
from ssao_gl.pipeline.presets import read_toml, settings_from
from ssao_gl.pipeline.settings import Settings, Shading
from ssao_gl.render.arrays import check_arrays
from ssao_gl.sampling.disk import Kernel, Rotation
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.projection import pixel_size
from ssao_gl.settings import as_table, assign, limits, validate

RECORDS = [*registry().values(), *FILTERS.values(), Shading, Kernel, Rotation]
one_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])

PRINTABLE = st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"])
"""What a message may repeat and still be one line; the command line replaces the rest."""
SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.integers(-3, 300), st.floats(), st.floats(-2, 2), st.text(PRINTABLE, max_size=8),
    st.sampled_from(["none", "auto", "true", "1e3", "0x10", "1_000", "nan", "-inf", "٣", "#fff", "#ff8000", "joint", "10" * 300]),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(PRINTABLE, max_size=4), inner, max_size=3)),
)


def refused(call: Callable[[], Any], kinds: type[SsaoError] | tuple[type[SsaoError], ...] = SettingsError) -> Any:
    """What the call gives, or None when it raises an error of ours, which must be one short line."""
    try:
        return call()
    except kinds as error:
        text = str(error)
        assert text and "\n" not in text.strip() and len(text) < 3000, text
        return None


def check(record: Any) -> None:
    """Every field within its limits."""
    validate(record)
    for field in dataclasses.fields(record):
        value, rule = getattr(record, field.name), limits(field)
        if isinstance(value, int | float) and not isinstance(value, bool):
            assert math.isfinite(value)
            assert rule.low is None or value >= rule.low
            assert rule.high is None or value <= rule.high
            assert rule.above is None or value > rule.above
        assert not rule.choices or value in rule.choices


# Settings


@given(st.data())
def test_assigned_settings_are_valid_or_refused(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(RECORDS))
    names = st.one_of(st.sampled_from([field.name for field in dataclasses.fields(kind)]), st.text(PRINTABLE, max_size=6))
    made = refused(lambda: assign(kind(), data.draw(st.dictionaries(names, VALUES, max_size=4))))
    if made is not None:
        check(made)


@given(st.data())
def test_valid_settings_survive_a_round_trip(data: st.DataObject) -> None:
    """As a table, as JSON, and as texts, which is how people write them."""
    kind = data.draw(st.sampled_from(RECORDS))
    changes = {}
    for field in dataclasses.fields(kind):
        rule, default = limits(field), getattr(kind(), field.name)
        if rule.choices:
            changes[field.name] = data.draw(st.sampled_from(rule.choices))
        elif isinstance(default, bool):
            changes[field.name] = data.draw(st.booleans())
        elif isinstance(default, int) and rule.high is not None:
            changes[field.name] = data.draw(st.integers(int(rule.low or 0), int(rule.high)))
    made = refused(lambda: assign(kind(), changes))
    if made is not None:
        table = as_table(made)
        assert assign(kind(), json.loads(json.dumps(table))) == made
        texts = {name: str(value) for name, value in table.items() if not isinstance(value, tuple | None)}
        assert as_table(assign(kind(), {**table, **texts})) == table


GROUPS = st.sampled_from(
    [*registry(), "blur", "shading", "blur_joint", "method", "preset", "normals", "precision", "keep", "alchmy", ""]
)
KEYS = st.one_of(
    st.sampled_from(["radius", "samples", "strength", "steps", "background", "normals", "x", ""]),
    st.text(PRINTABLE, max_size=5),
)
TABLES = st.dictionaries(GROUPS, st.one_of(SCALARS, st.dictionaries(KEYS, VALUES, max_size=3)), max_size=4)
NAMES = st.one_of(st.none(), st.sampled_from([*registry(), *FILTERS, "none", ""]), st.text(PRINTABLE, max_size=6))
ASSIGNMENTS = st.lists(
    st.one_of(
        st.text(PRINTABLE, max_size=10),
        st.builds("{}.{}={}".format, GROUPS, KEYS, SCALARS),
        st.builds("{}={}".format, KEYS, SCALARS),
    ),
    max_size=3,
)


@given(TABLES, NAMES, NAMES, ASSIGNMENTS, st.dictionaries(KEYS, SCALARS, max_size=2))
def test_settings_from_anything(
    table: dict[str, Any], method: str | None, blur: str | None, assignments: list[str], overrides: dict[str, Any]
) -> None:
    made = refused(
        lambda: settings_from(table, method_name=method, blur_name=blur, assignments=assignments, overrides=overrides)
    )
    if made is not None:
        assert isinstance(made, Settings)
        for record in (made.method, made.shading, *([made.blur] if made.blur else [])):
            check(record)
        json.dumps(made.table(), allow_nan=False)


def toml(table: dict[str, Any]) -> str:
    """Nearly TOML: Python's spelling of values."""
    plain = [f"{key} = {value!r}" for key, value in table.items() if not isinstance(value, dict)]
    groups = [
        f"[{key}]\n" + "\n".join(f"{k} = {v!r}" for k, v in value.items())
        for key, value in table.items()
        if isinstance(value, dict)
    ]
    return "\n".join(plain + groups)


@given(st.one_of(st.text(PRINTABLE, max_size=60), TABLES.map(toml)))
@one_folder
def test_any_settings_file(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    table = refused(lambda: read_toml(path))
    if table is not None:
        assert repr(table) == repr(tomllib.loads(path.read_text("utf-8")))  # nan is not equal to itself
        refused(lambda: settings_from(table))


@given(st.binary(max_size=60))
@one_folder
def test_any_bytes_as_settings_or_cameras(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(content)
    refused(lambda: read_toml(path))
    assert refused(lambda: load_cameras(path), SceneError) is None


# Sizes, vectors, arrays


@given(
    st.one_of(
        st.text(PRINTABLE, max_size=20),
        st.builds("{}x{}".format, SCALARS, SCALARS),
        st.builds("{}X{}".format, st.integers(), st.integers()),
    )
)
def test_any_size(text: str) -> None:
    made = refused(lambda: parse_size(text))
    if made is not None:
        assert all(1 <= side <= 65536 for side in made) and text.lower() == text.lower().strip()
        pixel_size(made)
        assert parse_size(f"{made[0]}x{made[1]}") == made


@given(st.one_of(st.text(PRINTABLE, max_size=20), st.lists(SCALARS, max_size=4).map(lambda parts: ",".join(map(str, parts)))))
def test_any_vector(text: str) -> None:
    made = refused(lambda: parse_vector("eye", text))
    if made is not None:
        assert len(made) == 3 and all(isinstance(part, float) for part in made)


SHAPES = st.lists(st.integers(0, 3), max_size=4).map(tuple)
DTYPES = st.sampled_from(["f2", "f4", "f8", "u1", "i4", "bool", "c8", "U3", "O", "M8[s]"])
ARRAYS = st.builds(lambda shape, dtype: np.zeros(shape, dtype), SHAPES, DTYPES)


@given(ARRAYS, st.one_of(st.none(), ARRAYS), st.one_of(st.none(), ARRAYS))
def test_any_arrays(depth: Any, color: Any, normals: Any) -> None:
    made = refused(lambda: check_arrays(depth, color, normals), SsaoError)
    if made is not None:
        z, c, n = made
        assert z.dtype == np.float32 and z.ndim == 2 and z.size
        assert c is None or (c.dtype == np.uint8 and c.shape[:2] == z.shape)
        assert n is None or (n.dtype == np.float32 and n.shape == (*z.shape, 3))


# Camera files

NUMBERS = st.one_of(st.floats(), st.floats(-5, 5), st.integers(-5, 5), VALUES)
VECTORS = st.one_of(st.lists(st.floats(-5, 5), min_size=3, max_size=3), st.lists(NUMBERS, max_size=4), VALUES)
ENTRIES = st.fixed_dictionaries(
    {},
    optional={
        "name": VALUES, "eye": VECTORS, "target": VECTORS, "up": VECTORS, "yfov_deg": NUMBERS, "ortho_height": NUMBERS,
        "znear": NUMBERS, "zfar": NUMBERS, "ao_radius": NUMBERS, "other": VALUES,
    },
)  # fmt: skip
GOOD = {"eye": [0, 0, 5], "target": [0, 0, 0], "yfov_deg": 40}


@given(
    st.one_of(
        VALUES, st.lists(st.one_of(ENTRIES, ENTRIES.map(lambda e: GOOD | e), VALUES), max_size=3).map(lambda c: {"cameras": c})
    )
)
@one_folder
def test_any_camera_file(tmp_path: Path, content: Any) -> None:
    """Cameras that can be used for an image, or one line that names the file."""
    path = tmp_path / "a.cam.json"
    path.write_text(json.dumps(content))
    made = refused(lambda: load_cameras(path), SceneError)
    if made is None:
        with pytest.raises(SceneError, match=r"a\.cam\.json"):
            load_camera(str(path))
        return
    for camera in made:
        assert isinstance(camera, Camera) and isinstance(camera.name, str)
        assert camera.ao_radius is None or 0 < camera.ao_radius < math.inf
        np.testing.assert_allclose(camera.pose[:3, :3].T @ camera.pose[:3, :3], np.eye(3), atol=1e-6)
        refused(lambda camera=camera: camera.view((64, 48)))
    for number, camera in enumerate(made):
        assert load_camera(f"{path}:{number}").name == camera.name or str(number) in [c.name for c in made]


@pytest.mark.filterwarnings("ignore::ssao_gl.errors.InputWarning")  # that the first of two is taken
@given(st.text(PRINTABLE, max_size=12))
@one_folder
def test_any_choice_of_a_camera(tmp_path: Path, choice: str) -> None:
    path = tmp_path / "a.cam.json"
    path.write_text(json.dumps({"cameras": [GOOD | {"name": "front"}, GOOD]}))
    made = refused(lambda: load_camera(f"{path}:{choice}"), SceneError)
    assert (made is not None) == (
        choice in ("front", "1", "0", "") or (choice.isascii() and choice.isdigit() and int(choice[:9]) < 2)
    )


# File names

PATHS = st.one_of(
    st.text(PRINTABLE, max_size=30),
    st.sampled_from(
        [".", "..", "/", "~", "-", "a.png/", "x" * 300 + ".png", "a\0b", "\udcff.png", "/dev/full", "/proc/1/x.png"]
    ),
)


@given(PATHS, st.sampled_from(["", ".png", ".npy", ".exr", ".gif", ".pngg"]))
@one_folder
def test_any_output_name(tmp_path: Path, name: str, suffix: str) -> None:
    """Checked before any work: fine, or one line; nothing is made. What is found fine can be written."""
    folder = tmp_path / "here"
    folder.mkdir(exist_ok=True)
    path = Path(f"{folder}/{name.lstrip('/')}{suffix}")
    if ".." in path.parts:
        return
    before = sorted(tmp_path.rglob("*"))
    assert refused(lambda: why_unreadable(path) or "fine", SsaoError)
    fine = refused(lambda: check_output("-o", path, (".png", ".npy", ".exr"), folder=True) or "fine", SsaoError)
    refused(lambda: check_writable(path), SsaoError)
    assert sorted(tmp_path.rglob("*")) == before
    if fine and path.suffix in (".png", ".npy"):
        from ssao_gl.io import images

        images.save_image(path, np.zeros((2, 2), np.uint8))
        assert images.load_image(path).shape == (2, 2)
        path.unlink()
