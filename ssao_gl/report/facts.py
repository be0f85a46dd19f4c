"""What a reader must know of how results came about."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def facts(found: Mapping[str, Any]) -> dict[str, str]:
    """Return what a reader must know of how results came about, in words."""
    made, settings = found["machine"], found["settings"]
    threads = ", ".join(f"{name}={value}" for name, value in made["threads"].items()) or "no thread variables set"
    truth = settings["truth"]
    return {
        "OpenGL": f"{made['provider']}, {made['renderer']}, {made['gl_version']}",
        "machine": f"{made['cpu']}, {made['cores']} cores, {threads}, {made['system']}",
        "versions": f"Python {made['python']}, " + ", ".join(f"{k} {v}" for k, v in made["packages"].items()),
        "commit": made["commit"] or "none",
        "date": found["made"],
        "truth": f"{truth['falloff']} falloff, {truth['normals']} normals, {truth['spp']} rays a pixel, seed {truth['seed']}",
        "timing": f"{settings['rounds']} interleaved rounds after one that warms up; "
        + ("wall clock, each pass waited for" if made["software"] else "GL's timer where there is one, else the wall clock"),
        "fitted on": ", ".join(found["scenes"]["fit"]) or "nothing",
        "held out": ", ".join(found["scenes"]["test"]) or "nothing",
    }
