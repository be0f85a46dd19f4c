"""The house rules that a machine can check."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.glsl import preprocess

PACKAGE = Path(ao.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
GL = ("gl", "render")
ADAPTERS = {"trimesh": "loaders", "pyrender": "loaders", "cyclopts": "cli", "rich": "cli"}


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
    for library, home in ADAPTERS.items():
        if library in imports(path):
            assert place == home, f"{library} is for {home}/"


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
