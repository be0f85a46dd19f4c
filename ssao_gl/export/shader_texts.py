"""Shader texts as an export holds them: one text a file, with the defines of each pass apart."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from ..glsl import preprocess
from ..glsl.compact import compact
from ..graph.draws import Define, Fullscreen
from ..graph.plan import Plan

DIALECT = "es300"
VERTEX, COPY = "fullscreen.vert", "copy.frag"
VIEW_DEFINES = ("PINHOLE",)
"""Defines that the projection decides: PINHOLE where all rays pass through the eye."""


@dataclass(slots=True)
class ShaderTexts:
    """Texts by name, each once. Compile ``version``, then the defines, then a text."""

    uses: Mapping[str, Sequence[Collection[str]]]
    """Shader file -> the names that each of its passes defines."""
    version: str = ""
    texts: dict[str, str] = field(default_factory=dict)

    def add(self, shader: str, defines: Mapping[str, Define]) -> str:
        """Take in a shader; return the name of its text, which is the file's unless its repeats differ."""
        lines = preprocess.build(shader, defines, DIALECT).text.splitlines()
        self.version = lines[0]
        sets = [frozenset(names) for names in self.uses.get(shader, [()])]
        maybe, always = frozenset().union(*sets, VIEW_DEFINES), sets[0].intersection(*sets)
        body = compact("\n".join(lines[1 + len(defines) :]), maybe, always)
        taken = [name for name, text in self.texts.items() if name.split("#")[0] == shader]
        name = next((name for name in taken if self.texts[name] == body), f"{shader}#{len(taken)}" if taken else shader)
        self.texts[name] = body
        return name


def shader_texts(plan: Plan) -> ShaderTexts:
    """Return the place for the texts of a plan."""
    uses: dict[str, list[Collection[str]]] = {}
    for step in plan.steps:
        if isinstance(step.task.draw, Fullscreen):
            uses.setdefault(step.task.draw.shader, []).append(step.task.draw.defines)
    return ShaderTexts(uses)
