"""What is behind a scene: chosen, the scene's own, or the calm default."""

from __future__ import annotations

import pytest

import ssao_gl as ao
from ssao_gl.pipeline.settings import CALM, Shading


@pytest.mark.parametrize(
    ("text", "rgba"),
    [
        ("white", (255, 255, 255, 255)),
        ("#204060", (32, 64, 96, 255)),
        ("#20406080", (32, 64, 96, 128)),
        ("transparent", (0, 0, 0, 0)),
    ],
)
def test_backgrounds(text: str, rgba: tuple[int, ...]) -> None:
    assert tuple(round(255 * value) for value in Shading(background=text).background_rgba) == rgba


@pytest.mark.parametrize("text", ["red", "#fff", "#12345", "#1234567", "255,0,0", ""])
def test_no_backgrounds(text: str) -> None:
    with pytest.raises(ao.SettingsError, match="must look like #rrggbb"):
        Shading(background=text)


def test_what_wins() -> None:
    """What was chosen, then the scene's own, then the default."""
    assert Shading(background="white").before((0, 0, 1, 1)).background == "white"
    assert Shading().before((0, 0, 1, 1)).background == "#0000ffff"
    assert Shading().before(None).background == CALM


def luminance(rgb: tuple[float, ...]) -> float:
    """Relative luminance of sRGB in 0..1 (WCAG 2.2)."""
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@pytest.mark.parametrize(("part", "least"), [(1.0, 2.0), (0.0, 5.0), (0.5, 1.5), (0.8, 1.2)])
def test_parts_stand_out_from_the_default(part: float, least: float) -> None:
    """White, black, middle grey and the default grey: contrast of the unshaded base colour, as WCAG 2.2 has it."""
    a, b = luminance((part,) * 3), luminance(Shading().background_rgba[:3])
    assert (max(a, b) + 0.05) / (min(a, b) + 0.05) >= least
