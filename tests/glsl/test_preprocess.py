"""Shader texts: assembled for three dialects, checked by the reference compiler where it is installed."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from ssao_gl.cli.shader import defaults
from ssao_gl.errors import ShaderError
from ssao_gl.glsl import preprocess

VALIDATOR = shutil.which("glslangValidator")


def variants() -> list[tuple[str, dict[str, preprocess.Define], str]]:
    found = []
    for name in preprocess.names():
        base = dict(defaults(name))
        extras: list[dict[str, preprocess.Define]] = [{}, {"PACKED": 1}] if name.startswith("methods/") else [{}]
        if name == "linearize.frag":
            extras.append({"WINDOW_DEPTH": 1})
        if name == "temporal.frag":
            extras += [{"MOVED": 1}, {"TARGETS": 1, "PACKED": 1, "SMALL": 1}]
        if name == "composite.frag":
            extras.append({"DIRECT": 1})
        if name in ("light.frag", "bounce.frag"):
            lamps: dict[str, preprocess.Define] = {"LAMPS": 8, "SHADOWS": 1, "SKY": 1}
            extras += [{"LAMPS": 0}, lamps]
        if name == "light.frag":
            extras += [{**lamps, "BENT_SKY": 1, "SPECULAR": 1, "BOUNCED": 1, "TONE": 1}, {"SPECULAR": 1, "TINT": 1, "LAMPS": 0}]
        for extra in extras:
            for dialect in preprocess.DIALECTS:
                if dialect != "es100" or preprocess.speaks_es100(name, base | extra):
                    found.append((name, base | extra, dialect))
    return found


@pytest.mark.skipif(VALIDATOR is None, reason="glslangValidator is not installed")
@pytest.mark.parametrize(("name", "defines", "dialect"), variants())
def test_every_variant_is_valid(name: str, defines: dict[str, preprocess.Define], dialect: str, tmp_path: Path) -> None:
    file = tmp_path / f"shader{Path(name).suffix}"
    file.write_text(preprocess.build(name, defines, dialect).text)
    assert VALIDATOR
    ran = subprocess.run([VALIDATOR, str(file)], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout


def test_methods_and_simple_passes_exist_for_webgl1() -> None:
    dialects = {(name, dialect) for name, _, dialect in variants()}
    for name in ("methods/lecture.frag", "methods/alchemy.frag", "composite.frag", "normals.frag", "linearize.frag"):
        assert (name, "es100") in dialects


def test_includes_come_once_and_lines_know_their_file() -> None:
    source = preprocess.build("methods/alchemy.frag", {"SAMPLES": 4})
    assert source.text.count("vec3 ssao_position(") == 1
    assert source.text.startswith("#version 300 es\n")
    line = next(i for i, text in enumerate(source.text.splitlines(), 1) if "ssao_decode_normal(vec2 e)" in text)
    assert source.locate(f"0:{line}: error").startswith("lib/normal.glsl:")


def test_repeat_writes_the_line_out() -> None:
    text = preprocess.build("denoise_joint.frag", {"RADIUS": 3, "PACKED": 1}).text
    assert text.count("float(2 + 1)") == 2 and "#repeat" not in text


@pytest.mark.parametrize(
    ("name", "dialect", "message"),
    [
        ("methods/alchmy.frag", "es300", "Did you mean 'methods/alchemy.frag'"),
        ("composite.frag", "es30", "Did you mean 'es300'"),
        ("denoise_joint.frag", "es100", "es300"),
        ("denoise_joint.frag", "gl330", "#repeat needs a number"),
    ],
)
def test_errors_say_what_to_do(name: str, dialect: str, message: str) -> None:
    with pytest.raises(ShaderError, match=re.escape(message)):
        preprocess.build(name, {}, dialect)


def test_functions_of_the_library_carry_our_prefix() -> None:
    """So that a shader can be pasted into another program without clashes."""
    for path in (preprocess.root() / "lib").glob("*.glsl"):
        for name in re.findall(r"^(?:float|vec\d|mat\d|void|uint|bool)\s+(\w+)\s*\(", path.read_text(), re.M):
            assert name.startswith("ssao_"), f"{path.name}: {name}"
