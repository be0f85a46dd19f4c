"""The house rules that a machine can check."""

from __future__ import annotations

import ast
import re
import statistics
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.glsl import preprocess

PACKAGE = Path(ao.__file__).parent
TESTS = Path(__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
GL = ("gl", "render")
DOORS = {
    "trimesh": "loaders",
    "pyrender": "loaders",
    "pyvista": "loaders",
    "open3d": "loaders",
    "embreex": "truth",
    "xatlas": "bake",
    "matplotlib": "report",
    "cyclopts": "cli",
    "rich": "cli",
}


def imports(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add((node.module or "").split(".")[0])
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_libraries_stay_in_their_places(path: Path) -> None:
    place = path.relative_to(PACKAGE).parts[0]
    if "moderngl" in imports(path):
        assert place in GL, "moderngl is for gl/ and render/"
    for library, home in DOORS.items():
        if library in imports(path):
            assert place == home, f"{library} is for {home}/"


def test_render_is_the_function_whatever_was_imported() -> None:
    import ssao_gl.render.renderer  # noqa: F401 - which has the name of the function

    assert callable(ao.render) and ao.render.__module__ == "ssao_gl.api"


@pytest.mark.parametrize("path", sorted((PACKAGE / "gl").glob("*.py")), ids=lambda p: p.name)
def test_no_driver_gets_the_address_of_what_is_gone(path: Path) -> None:
    """Whose address is taken must have a name: ``addressof(c_float(1))`` is free before the call, for any thread to write to."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) == "addressof":
            assert not isinstance(node.args[0], ast.Call), f"line {node.lineno}: pass the value itself, or byref()"


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_no_shader_text_in_python(path: Path) -> None:
    assert not re.search(r"#version \d|gl_FragColor|gl_Position", path.read_text())


@pytest.mark.parametrize("name", ao.registry())
def test_a_method_has_a_shader_and_says_its_source(name: str) -> None:
    kind = ao.registry()[name]
    assert (preprocess.root() / kind.shader).is_file()  # type: ignore[attr-defined]
    assert re.search(r"\b(19|20)\d\d\b", kind.__doc__ or "")


def test_every_setting_has_words_and_limits() -> None:
    import dataclasses

    from ssao_gl.passes.denoise import FILTERS
    from ssao_gl.settings import limits

    for kind in (*ao.registry().values(), *FILTERS.values(), ao.Shading, ao.Kernel, ao.Rotation):
        for field in dataclasses.fields(kind):
            assert limits(field).doc, f"{kind.__name__}.{field.name}"


COMMANDS = {
    "apply",
    "bake",
    "batch",
    "bench",
    "compare",
    "export",
    "main",
    "render",
    "report",
    "sheet",
    "truth",
    "explain",
    "methods",
    "shader",
    "doctor",
    "stress",
}
"""Commands are called as people type them, which is how the API calls what they do; ``main`` is where a program starts."""

OPENERS = {"open_context"}
"""Each way to OpenGL has one."""


def functions(path: Path) -> Iterator[ast.FunctionDef]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            yield node


def test_no_two_public_things_share_a_name() -> None:
    """Cases of the stress test are told apart by the decorator's name; only their own rooms see them."""
    where = defaultdict(list)
    for path in FILES:
        if "cases" in path.parts:
            continue
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
                where[node.name].append(path.relative_to(PACKAGE).as_posix())
    shared = {name: files for name, files in where.items() if len(files) > 1 and name not in COMMANDS | OPENERS}
    assert not shared


def test_the_house_is_small_enough_to_be_known() -> None:
    doors = [path for path in PACKAGE.iterdir() if not path.name.startswith(".") and path.name != "__pycache__"]
    lines = {path: len(path.read_text().splitlines()) for path in FILES}
    assert len(doors) <= 32 and max(lines.values()) <= 320 and statistics.median(lines.values()) <= 110


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_functions_fit_on_a_screen(path: Path) -> None:
    for function in functions(path):
        given = function.args
        count = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
        own = bool(given.posonlyargs + given.args) and (given.posonlyargs + given.args)[0].arg in ("self", "cls")
        assert (function.end_lineno or 0) - function.lineno < 60, function.name
        assert count - own <= 10, function.name


@pytest.mark.parametrize("room", sorted(p.name for p in PACKAGE.iterdir() if (p / "__init__.py").is_file()))
def test_every_room_says_what_it_is(room: str) -> None:
    assert len((ast.get_docstring(ast.parse((PACKAGE / room / "__init__.py").read_text())) or "").split()) >= 5


def test_tests_lie_where_the_code_lies() -> None:
    """Each test file of a room is named after a file of that room, with what it asks for beside it where that is one thing."""
    suites = {"contract", "robustness", "images"}
    for path in TESTS.rglob("test_*.py"):
        room, *rest = path.relative_to(TESTS).parts
        if not rest or room in suites:
            continue
        name = path.stem.removeprefix("test_")
        files = {file.stem for file in (PACKAGE / room).glob("*.py")}
        assert any(name == file or name.startswith(f"{file}_") for file in files) or name in {"commands", "plugins"}, path


ASKING = re.compile(
    r"\b(?:getattr|hasattr)\(\s*(?:self\.)?(?:settings\.)?(?:method|blur|filter|record|kind|one)\b(?!, (?:f|field)\.name)"
)


@pytest.mark.parametrize("path", [p for p in FILES if p.name != "settings.py"], ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_methods_and_filters_are_asked_by_their_traits(path: Path) -> None:
    """No attribute that their protocol does not declare, and no category by the name of a pass."""
    text = path.read_text()
    assert not ASKING.search(text)
    if path.parent.name not in ("passes", "pipeline"):
        assert not re.search(r"""name\.startswith\(["']blur|\.name == ["'](gbuffer|layer behind|composite)""", text)
    assert not re.search(r"isinstance\([^)]*\b(Joint|Separable|LectureBlur|Bitmask|Alchemy|Lecture|Reference)\b", text)


@pytest.mark.parametrize("name", ao.registry())
def test_traits_tell_what_is_read(name: str) -> None:
    from ssao_gl.graph import names
    from ssao_gl.methods.traits import CAMERAS, INPUTS, OUTPUTS

    kind = ao.registry()[name]
    inputs = {
        names.DEPTH: "depth", names.PIXEL_DEPTH: "depth", names.DEPTH_OVER_FAR: "depth", names.NORMAL: "normal",
        names.PIXEL_NORMAL: "normal", names.DEPTH_LAYER_2: "second_layer",
        names.DEPTH_RANGE: "depth_table", names.DEPTH_TABLE: "depth_table", names.BAKED: "baked", names.HIDDEN: "scene",
        names.FIELD: "prepared", names.FIELD_COARSE: "prepared",
    }  # fmt: skip
    for preset in ({}, *kind.presets.values()):
        method = kind(**preset)
        traits = method.traits
        assert {inputs[resource] for resource in method.samplers.values()} == traits.inputs <= set(INPUTS)
        assert traits.outputs <= set(OUTPUTS) and traits.cameras <= set(CAMERAS)
        assert traits.taps_setting is None or hasattr(method, traits.taps_setting)
        assert traits.noise_tile >= 0 and traits.scale >= 1 and traits.guard_band >= 0
