"""``--rays``: by option, by ``--set``, by file; in tiles; and who refuses it, in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssao_gl.errors import SettingsError
from ssao_gl.pipeline.presets import as_rays, settings_from, settings_toml
from ssao_gl.pipeline.residual import residual_reach

from ..command_line import refused, run

SIZE = ("--size", "96x64")


def test_shares_as_people_write_them() -> None:
    assert [as_rays(text) for text in ("0.25", "1/4", "2", "1e-2")] == [0.25, 0.25, 2.0, 0.01]
    for text in ("x", "1/0", "", "1/2/3"):
        with pytest.raises(SettingsError, match="must be a number of rays a pixel"):
            as_rays(text)


def test_settings_by_any_way() -> None:
    assert settings_from({"rays": 0.5}).rays == 0.5 and settings_from({"rays": 0.5}, rays=0.25).rays == 0.25
    assert settings_from({}, assignments=["rays=1/4"]).rays == 0.25 and settings_from().rays == 0
    assert "rays" not in settings_toml(settings_from().table()) and "rays = 0.25" in settings_toml(
        settings_from(rays=0.25).table()
    )
    with pytest.raises(SettingsError, match="rays='many'"):
        settings_from({"rays": "many"})
    assert residual_reach(settings_from()) == 0 and residual_reach(settings_from(rays=0.1)) >= 10


@pytest.mark.gl
def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("embreex")
    code, out, _ = run(
        "render", *SIZE, "--rays", "1/4", "-o", tmp_path / "a.npy", "--dump-config", tmp_path / "a.toml", capsys=capsys
    )
    assert code == 0 and "0.25 rays a pixel" in out
    for name, more in (("b", ("--config", tmp_path / "a.toml")), ("c", ("--rays", "0.25", "--tile", "64")), ("d", ())):
        assert run("render", *SIZE, *more, "-o", tmp_path / f"{name}.npy", capsys=capsys)[0] == 0
    a, b, c, d = (np.load(tmp_path / f"{name}.npy").astype(float) for name in "abcd")
    assert (a == b).all() and np.abs(a - c).mean() < 2e-3 < np.abs(a - d).mean()
    code, out, _ = run("explain", *SIZE, "--rays", "1/4", capsys=capsys)
    assert code == 0 and " rays " in out and "residual filter x" in out


def test_refusals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "z.npy", np.ones((8, 8), np.float32))
    assert "must be a number of rays" in refused(capsys, "render", "--rays", "some")
    assert "must be 0 to 4096" in refused(capsys, "render", "--rays", "-1")
    assert "no scene to trace" in refused(capsys, "apply", "--depth", tmp_path / "z.npy", "--yfov-deg", "40", "--rays", "1")
    assert "--max-error choose that" in refused(capsys, "render", "--rays", "1", "--max-error", "0.1")
    assert "use bitmask" in refused(capsys, "explain", "--method", "lecture", "--rays", "1")
    assert "no such preset here" in refused(capsys, "report", "--presets", "medium", "--rays", "ultra+1")
