"""Colours as settings have them: sRGB texts."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..errors import SettingsError, near_miss
from ..scene.srgb import decode

HEX = re.compile(r"#[0-9a-fA-F]{6}(?:[0-9a-fA-F]{2})?")
NAMED: Mapping[str, str] = {"white": "#ffffff", "black": "#000000", "transparent": "#00000000"}
SOLID = {name: NAMED[name] for name in ("white", "black")}


def check_color(field: str, value: str, names: Mapping[str, str]) -> None:
    """Raise SettingsError for what is no colour."""
    if not HEX.fullmatch(names.get(value, value)):
        raise SettingsError(
            f"{field}='{value}': must look like #rrggbb or #rrggbbaa, or be one of {', '.join(names)}" + near_miss(value, names)
        )


def rgba(color: str) -> tuple[float, float, float, float]:
    """Return sRGB and alpha in 0..1."""
    digits = NAMED.get(color, color)[1:].ljust(8, "f")
    r, g, b, a = (int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4, 6))
    return r, g, b, a


def linear_rgb(color: str) -> tuple[float, float, float]:
    """Return linear light in 0..1."""
    r, g, b = (float(part) for part in decode(rgba(color)[:3]))
    return r, g, b
