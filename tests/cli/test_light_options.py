"""``--light``, ``--shadows``, ``--environment``, ``--indirect``: what they ask for, and what is refused in one line."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.cli.light_options import LightOptions
from ssao_gl.pipeline.light import Light
from ssao_gl.pipeline.presets import settings_from, settings_toml

from ..command_line import refused, run


def lit(**options: object) -> Light | None:
    return LightOptions(**options).onto(ao.Settings()).light  # type: ignore[arg-type]


def test_what_the_options_mean(tmp_path: Path) -> None:
    assert lit() is None
    assert lit(shadows=True) == Light(shadows=True)
    assert lit(light="-30,60") == Light(azimuth=-30.0, elevation=60.0)
    assert lit(light="scene") == Light(lamps="scene")
    assert lit(environment="white") == Light(environment="white", intensity=0.0)  # it needs no key light beside it
    assert lit(environment="white", shadows=True) == Light(environment="white", shadows=True)
    assert lit(indirect="bitmask", tone="neutral") == Light(indirect="bitmask", tone="neutral")
    Image.fromarray(np.full((8, 16, 3), 255, np.uint8)).save(tmp_path / "white.png")
    made = lit(environment=str(tmp_path / "white.png"))
    assert made is not None
    np.testing.assert_allclose(made.sky, lit(environment="white").sky, atol=0.02)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"light": "40"}, "--light 40: must be azimuth,elevation"),
        ({"light": "1,x"}, "--light 1,x: must be azimuth,elevation"),
        ({"light": "0,95"}, "light.elevation=95.0: must be -90 to 90"),
        ({"environment": "ski"}, "--environment ski: must be none, white, sky, or the file"),
        ({"indirect": "sddo"}, "light.indirect='sddo': must be one of none, tint, bitmask, ssdo, rsm"),
        ({"tone": "aces"}, "light.tone='aces'"),
    ],
)
def test_what_is_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(ao.SettingsError, match=message.replace(".", r"\.")):
        lit(**options)


def test_light_lives_in_settings_files() -> None:
    settings = LightOptions(light="10,20", shadows=True).onto(ao.Settings())
    again = settings_from(tomllib.loads(settings_toml(settings.table())))
    assert again.light == settings.light
    assert "light" not in ao.Settings().table()
    assert settings_from(assignments=["light.intensity=2"]).light == Light(intensity=2.0)


@pytest.mark.gl
def test_a_lit_picture_by_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pictures = []
    for name, options in (("plain", []), ("lit", ["--light", "-40", "50", "--shadows"])):
        code, _, error = run("render", "-o", tmp_path / f"{name}.png", "--size", "96x64", *options, capsys=capsys)
        assert code == 0, error
        pictures.append(np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB")).astype(int))
    assert np.abs(pictures[0] - pictures[1]).max() > 30
    missing = tmp_path / "none.hdr"
    assert "no such file" in refused(capsys, "render", "-o", tmp_path / "x.png", "--environment", missing)
    assert not (tmp_path / "x.png").exists()
