"""``ssao-gl doctor``: which OpenGL there is on this machine, and the cure where there is none."""

from __future__ import annotations

import json as json_module
import subprocess
import sys
from typing import Annotated, Any

from cyclopts import Parameter

from ..gl.providers import PROVIDERS, Provider
from .output import print_table, say

TIMEOUT_S = 60


def doctor(
    *,
    json: Annotated[bool, Parameter(name="--json", negative="", help="As JSON.")] = False,
    probe: Annotated[str | None, Parameter(show=False)] = None,
) -> int:
    """Try every OpenGL provider and print a table: version, renderer, limits that matter, or why it failed and the cure.

    Exits with 3 when there is none.
    """
    if probe is not None:
        return _probe(probe)
    found = {provider.name: _tried(provider) for provider in PROVIDERS.values()}
    working = any(one["works"] for one in found.values())
    if json:
        say(json_module.dumps({"works": working, "providers": found}, indent=1))
    else:
        rows = [(name, "ok" if one["works"] else "no", _line(one)) for name, one in found.items()]
        print_table(
            "OpenGL providers, in the order of --gl auto", ("provider", "", "version, renderer, limits; or why not"), rows
        )
        if not working:
            say("No OpenGL at all. The cure that needs no root: pip install 'ssao_gl[software]'")
    return 0 if working else 3


def _tried(provider: Provider) -> dict[str, Any]:
    """Return what a provider says of itself, or why it does not open, and the cure."""
    # In a process of its own: a driver that crashes must not take the table with it.
    command = [sys.executable, "-m", "ssao_gl", "doctor", "--probe", provider.name]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired:
        return {"works": False, "reason": f"no answer within {TIMEOUT_S} s", "cure": provider.cure}
    lines = ran.stdout.strip().splitlines()
    if ran.returncode == 0 and lines:
        return {"works": True, **json_module.loads(lines[-1])}
    reason = lines[-1] if lines else f"the driver crashed (exit {ran.returncode})"
    return {"works": False, "reason": reason, "cure": provider.cure}


def _line(one: dict[str, Any]) -> str:
    if not one["works"]:
        return f"{one['reason']}. Cure: {one['cure']}"
    return "{version}, {renderer}, {platform}, textures to {largest_texture}, {timer}".format(**one)


def _probe(name: str) -> int:
    """Print what a provider is, as one line of JSON; or why it does not open."""
    try:
        with PROVIDERS[name].open() as context:
            about = {
                "version": context.version,
                "renderer": context.renderer,
                "platform": context.platform,
                "largest_texture": context.max_size,
                "timer": "GL timer" if context.gpu_timer else "wall-clock timer",
            }
            say(json_module.dumps(about))
        return 0
    except Exception as error:  # whatever a driver does wrong belongs in the table
        say(" ".join(str(error).split()) or type(error).__name__)
        return 1
