"""Colour dimmed by visibility."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Fullscreen
from ..graph.names import COLOR, IMAGE, VISIBILITY

IMAGES = ("composite", "light")
"""Passes that draw the image by visibility."""


def composite(
    ambient: float, background: Sequence[float], *, direct: bool, test: DepthTest | None = None, result: str = IMAGE
) -> Pass:
    """Draw ``result``: colour times light, its ambient share dimmed by visibility; ``background`` (sRGB, alpha) where ``test`` finds nothing.

    ``direct``: alpha of colour is direct light.
    """
    samplers = {"u_color": COLOR, "u_visibility": VISIBILITY}
    draw = Fullscreen("composite.frag", samplers, {"u_ambient": ambient}, defines={"DIRECT": 1} if direct else {})
    return Pass("composite", "composite", draw, {result: Texture("rgba8")}, test=test, clear=tuple(background))


def toned(passes: Sequence[Pass], power: float, tint: tuple[float, float, float]) -> list[Pass]:
    """Return the passes with an image whose visibility is raised to ``power``, and whose hidden light is ``tint`` (linear)."""

    def tone(task: Pass) -> Pass:
        if task.name not in IMAGES or not isinstance(task.draw, Fullscreen):
            return task
        uniforms, defines = {**task.draw.uniforms, "u_power": power, "u_tint": tint}, {**task.draw.defines, "TONED": 1}
        return replace(task, draw=replace(task.draw, uniforms=uniforms, defines=defines))

    return [tone(task) for task in passes]
