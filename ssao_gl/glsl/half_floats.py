"""Half floats on any driver: a shader's text with every LOW variable rounded where it is set. For tests; see lib/precision.glsl."""

from __future__ import annotations

import re

_FUNCTIONS = re.compile(r"(?m)^(?=\})")
_DECLARED = re.compile(r"\bLOW \w+ (\w+)")
_ASSIGNED = re.compile(r"//.*|(\w+\.)?\b(\w+) ([-+*/]?)= ([^;]*);")


def emulate_half_floats(text: str) -> str:
    """``x = value;`` as ``x = ssao_half(value);`` for each float, vec2, vec3 or vec4 ``x`` that is declared LOW in the same
    function, or as a member of a struct. Lines keep their numbers."""
    members = {name for part in _FUNCTIONS.split(text) if "struct " in part for name in _members(part)}

    def function(part: str) -> str:
        names = set(_DECLARED.findall(part))

        def assign(match: re.Match[str]) -> str:
            owner, name, operator, value = match.groups(default="")
            if name not in (members if owner else names):
                return match[0]
            before = f"{owner}{name} {operator} (" if operator else ""
            return f"{owner}{name} = ssao_half({before}{value}{')' if operator else ''});"

        return _ASSIGNED.sub(assign, part)

    return "".join(map(function, _FUNCTIONS.split(text)))


def _members(part: str) -> list[str]:
    return _DECLARED.findall(part[part.index("struct ") :])
