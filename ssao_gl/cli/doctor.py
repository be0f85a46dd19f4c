"""``ssao-gl doctor``: which OpenGL there is on this machine, and the cure where there is none."""

from __future__ import annotations

import subprocess
import sys
from typing import Annotated

from cyclopts import Parameter

from ..gl.providers import PROVIDERS
from .output import print_table, say

TIMEOUT_S = 60


def doctor(*, probe: Annotated[str | None, Parameter(show=False)] = None) -> int:
    """Try every OpenGL provider and print a table: version, renderer, limits that matter, or why it failed and the cure."""
    if probe is not None:
        return _probe(probe)
    rows = []
    working = 0
    for provider in PROVIDERS.values():
        # In a process of its own: a driver that crashes must not take the table with it.
        command = [sys.executable, "-m", "ssao_gl", "doctor", "--probe", provider.name]
        try:
            ran = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
            lines = ran.stdout.strip().splitlines()
            if ran.returncode == 0 and lines:
                working += 1
                rows.append((provider.name, "ok", lines[-1]))
                continue
            reason = lines[-1] if lines else f"the driver crashed (exit {ran.returncode})"
        except subprocess.TimeoutExpired:
            reason = f"no answer within {TIMEOUT_S} s"
        rows.append((provider.name, "no", f"{reason}. Cure: {provider.cure}"))
    print_table("OpenGL providers, in the order of --gl auto", ("provider", "", "version, renderer, limits; or why not"), rows)
    if not working:
        say("No OpenGL at all. The cure that needs no root: pip install 'ssao_gl[software]'")
        return 3
    return 0


def _probe(name: str) -> int:
    try:
        with PROVIDERS[name].open() as context:
            timer = "GL timer" if context.gpu_timer else "wall-clock timer"
            say(f"{context.version}, {context.renderer}, {context.platform}, textures to {context.max_size}, {timer}")
        return 0
    except Exception as error:  # whatever a driver does wrong belongs in the table
        say(" ".join(str(error).split()) or type(error).__name__)
        return 1
