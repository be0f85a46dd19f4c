"""Colour dimmed by visibility."""

from __future__ import annotations

from collections.abc import Sequence

from ..gl.executor import Stage
from ..graph.declare import Pass, Texture


def composite(ambient: float, background: Sequence[float], *, direct: bool) -> Pass:
    """``image``: colour times light, its ambient share dimmed by visibility; ``background`` (sRGB) where there is nothing.

    ``direct``: alpha of colour is direct light.
    """

    def draw(stage: Stage) -> None:
        stage.fullscreen(
            "composite.frag",
            {"u_ambient": ambient},
            {"u_color": "color", "u_visibility": "visibility"},
            defines={"DIRECT": 1} if direct else {},
        )

    return Pass("composite", ("color", "visibility"), {"image": Texture("rgba8")}, draw, clear=(*background, 1.0))
