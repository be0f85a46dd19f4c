"""Colour dimmed by visibility."""

from __future__ import annotations

from collections.abc import Sequence

from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Fullscreen
from ..graph.names import COLOR, IMAGE, VISIBILITY


def composite(
    ambient: float, background: Sequence[float], *, direct: bool, test: DepthTest | None = None, result: str = IMAGE
) -> Pass:
    """Draw ``result``: colour times light, its ambient share dimmed by visibility; ``background`` (sRGB, alpha) where ``test`` finds nothing.

    ``direct``: alpha of colour is direct light.
    """
    samplers = {"u_color": COLOR, "u_visibility": VISIBILITY}
    draw = Fullscreen("composite.frag", samplers, {"u_ambient": ambient}, defines={"DIRECT": 1} if direct else {})
    return Pass("composite", "composite", draw, {result: Texture("rgba8")}, test=test, clear=tuple(background))
