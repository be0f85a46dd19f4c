"""Native OpenGL ES 3: shaders as files, the pipeline as a C header, and a small program that runs it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .formulas import VIEW_FORMULAS, Formula, number
from .pipeline import Pipeline
from .shader_texts import DIALECT, VERTEX

SOURCES = Path(__file__).parent / "gles3"
FORMATS: Mapping[str, str] = {"depth24": "GL_DEPTH_COMPONENT24"}
"""Formats of which OpenGL's name is not the same in capitals."""
ARGUMENTS = ("depth", "normals", "color")
"""Inputs in the order of ``SsaoInputs``."""


def native_files(made: Pipeline) -> Mapping[str, str]:
    """Return the files of the target."""
    folder = {f"shaders/{name}": text for name, text in _shader_files(made).items()}
    copied = {name: (SOURCES / name).read_text("utf-8") for name in ("ssao.h", "ssao.c", "view.h", "main.c")}
    return {"pipeline.h": _Header(made).text(), **copied, **folder}


def _shader_files(made: Pipeline) -> dict[str, str]:
    """Return name -> complete text of each step's shader, and of the vertex shader."""
    files = {VERTEX: f"{made['version_line']}\n{made['shaders'][made['vertex']]}"}
    for index, step in enumerate(made["steps"]):
        defines = "".join(f"#define {name} {value}\n" for name, value in step["defines"].items())
        files[_file(index, step)] = f"{made['version_line']}\n{defines}{made['shaders'][step['shader']]}"
    return files


def _file(index: int, step: Mapping[str, Any]) -> str:
    return f"{index:02d}-{step['name'].replace(' ', '-')}.frag"


@dataclass(slots=True)
class _Header:
    """``pipeline.h`` in the making."""

    made: Pipeline
    parts: list[str] = field(default_factory=list)
    uniforms: list[str] = field(default_factory=list)
    samplers: list[str] = field(default_factory=list)

    @property
    def live(self) -> dict[tuple[str, int], tuple[str, float]]:
        """(setting, component) -> what C calls it, and its value."""
        found = {}
        for name, one in self.made["live"].items():
            values = one["value"] if isinstance(one["value"], list) else [one["value"]]
            for part, value in enumerate(values):
                found[name, part] = (name if len(values) == 1 else f"{name}.{'rgb'[part]}", value)
        return found

    @property
    def resources(self) -> list[str]:
        """Inputs first, of which those that are not taken have no name; then the others."""
        return [*(self.made["inputs"].get(name, {}).get("resource", "") for name in ARGUMENTS), *self.made["resources"]]

    def text(self) -> str:
        made = self.made
        standard = self._uniforms(made["standard"])
        steps = [self._step(index, step) for index, step in enumerate(made["steps"])]
        takes = ", ".join(str(int(name in made["inputs"])) for name in ARGUMENTS)
        tables = list(made["tables"].values())
        names = [f"SSAO_VIEW_{name.upper()}" for name in VIEW_FORMULAS]
        return "\n".join(
            [
                (SOURCES / "types.h").read_text("utf-8"),
                f"/* {made['generator']}, {DIALECT}: {made['settings']['method']}. Left out:",
                *(f"   {name}: {why.replace('*/', '')}" for name, why in made["left_out"].items()),
                "*/",
                *(f"/* {name}: {meaning} */" for name, meaning in zip(names, VIEW_FORMULAS.values(), strict=True)),
                f"enum {{ {', '.join(names)}, SSAO_VIEWS }};",
                f"enum {{ SSAO_LARGEST = {made['largest']}, SSAO_OUTPUT = {self.resources.index(made['output']['resource'])} }};",
                f"enum {{ SSAO_NEEDS_PERSPECTIVE = {int('perspective' in made['cameras'])},"
                f" SSAO_NEEDS_FAR_PLANE = {int('far plane' in made['cameras'])} }};",
                f"static const int SSAO_TAKES[SSAO_INPUTS] = {{{takes}}};",
                f'static const char SSAO_VERTEX[] = "{VERTEX}";',
                _array("SsaoSetting", "SSAO_SETTINGS", (_setting(*self.live[key], made["live"][key[0]]) for key in self.live)),
                _array("SsaoSlot", "SSAO_SLOTS", (f"{{{_format(one['format'])}, {one['scale']}}}" for one in made["slots"])),
                f"/* {', '.join(name or 'none' for name in self.resources)} */",
                _array("int", "SSAO_RESOURCE_SLOTS", (str(made["resources"].get(name, -1)) for name in self.resources)),
                *(_floats(f"SSAO_TABLE_{i}", table["data"]) for i, table in enumerate(tables)),
                _array("SsaoTable", "SSAO_TABLES", (_table(i, table) for i, table in enumerate(tables))),
                _array("SsaoPart", "SSAO_PARTS", self.parts),
                _array("SsaoUniform", "SSAO_UNIFORMS", self.uniforms),
                _array("SsaoSampler", "SSAO_SAMPLERS", self.samplers),
                f"static const SsaoRange SSAO_STANDARD = {standard};",
                _array("SsaoStep", "SSAO_STEPS", steps),
                "",
            ]
        )

    def _step(self, index: int, step: Mapping[str, Any]) -> str:
        depth, clears = step.get("depth"), step.get("clear") or [None] * len(step["writes"])
        fields = {
            "name": f'"{step["name"]}"',
            "shader": f'"{_file(index, step)}"',
            "scale": step["scale"],
            "write_count": len(step["writes"]),
            "writes": _list(self.resources.index(name) for name in step["writes"]),
            "clears": _list(int(value is not None) for value in clears),
            "clear": _list(_list(map(_float, value or [0])) for value in clears),
            "depth_slot": depth["slot"] if depth else -1,
            "depth_writes": int(depth["writes"]) if depth else 0,
            "depth_passes": f"GL_{depth['passes'].upper()}" if depth else "GL_ALWAYS",
            "least": _list(least or 0 for least in step.get("when", (1, 1))),
            "samplers": self._range(self.samplers, self._samplers(step["samplers"], self.resources)),
            "tables": self._range(self.samplers, self._samplers(step.get("tables", {}), list(self.made["tables"]))),
            "uniforms": self._uniforms(step["uniforms"]),
        }
        return "{" + ", ".join(f".{name} = {value}" for name, value in fields.items()) + "}"

    def _samplers(self, samplers: Mapping[str, str], names: Sequence[str]) -> list[str]:
        return [f'{{"{uniform}", {names.index(name)}}}' for uniform, name in samplers.items()]

    def _uniforms(self, uniforms: Mapping[str, Formula]) -> str:
        found = []
        for name, value in uniforms.items():
            parts = self._range(self.parts, map(self._part, value if isinstance(value, list) else [value]))
            found.append(f'{{"{name}", {parts[1:-1]}}}')
        return self._range(self.uniforms, found)

    def _range(self, array: list[str], more: Iterable[str]) -> str:
        first = len(array)
        array += more
        return f"{{{first}, {len(array) - first}}}"

    def _part(self, value: Formula) -> str:
        if not isinstance(value, Mapping):
            return f"{{SSAO_NUMBER, 0, {value!r}, -1, 0, -1, 0}}"
        factor, by, live = value.get("factor", 1.0), -1, list(self.live)
        if isinstance(factor, Mapping):
            by, factor = live.index((factor["setting"], factor.get("part", 0))), factor.get("factor", 1.0)
        kind, what = ("SSAO_VIEW", f"SSAO_VIEW_{value['view'].upper()}") if "view" in value else ("SSAO_SETTING", "")
        what = what or str(live.index((value["setting"], value.get("part", 0))))
        resource = self.resources.index(value["resource"]) if "resource" in value else 0
        return f"{{{kind}, {what}, {factor!r}, {by}, {int(value.get('inverse', False))}, {value.get('axis', -1)}, {resource}}}"


def _array(kind: str, name: str, items: Iterable[str]) -> str:
    """Return a C array; one without items gets an empty one, as C has no arrays of nothing."""
    lines = ",\n".join(f"    {item}" for item in items) or "    {0}"
    return f"static const {kind} {name}[] = {{\n{lines},\n}};"


def _floats(name: str, values: Sequence[float]) -> str:
    rows = [", ".join(map(_float, values[i : i + 8])) for i in range(0, len(values), 8)]
    return _array("float", name, rows)


def _float(value: float) -> str:
    return f"{float(number(value))!r}f"


def _list(items: Iterable[object]) -> str:
    return "{" + ", ".join(map(str, items)) + "}"


def _format(name: str) -> str:
    return FORMATS.get(name, f"GL_{name.upper()}")


def _table(index: int, table: Mapping[str, Any]) -> str:
    return f"{{{table['width']}, {table['height']}, {table['channels']}, SSAO_TABLE_{index}}}"


def _setting(name: str, value: float, live: Mapping[str, Any]) -> str:
    bounds = [live.get("above", -1e300), live.get("low", -1e300), live.get("high", 1e300)]
    return f'{{"{name}", {value!r}, {", ".join(repr(float(bound)) for bound in bounds)}}}'
