"""``ssao-gl view``: pages of scenes, and what is refused."""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path

import numpy as np
import pytest

from ..command_line import refused, run

CAMERAS = {"cameras": [{"name": name, "eye": [5, x, 6], "target": [0, 1, 0], "yfov_deg": 40} for x, name in enumerate("ab")]}


def cameras_of(page: Path) -> list[str]:
    packed = re.search(r'id="scene">([^<]*)<', page.read_text("utf-8"))
    assert packed
    head = json.loads(gzip.decompress(base64.b64decode(packed[1])).split(b"\n", 1)[0])
    return [camera["name"] for camera in head["cameras"]]


def test_all_cameras_of_a_file_or_the_named_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "c.json").write_text(json.dumps(CAMERAS))
    page = tmp_path / "a.html"
    code, out, err = run("view", "-o", page, "--camera", tmp_path / "c.json", "--size", "64x36", capsys=capsys)
    assert code == 0 and not err and "3 cameras" in out and cameras_of(page) == ["a", "b", "default"]
    assert run("view", "-o", page, "--camera", f"{tmp_path / 'c.json'}:b", "--size", "64x36", capsys=capsys)[0] == 0
    assert cameras_of(page) == ["b", "default"]


def test_rays_of_every_camera(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "a.html"
    assert run("view", "-o", page, "--truth", "--spp", "1", "--no-cache", "--size", "64x36", capsys=capsys)[0] == 0
    packed = re.search(r'id="options">([^<]*)<', page.read_text("utf-8"))
    assert packed
    options = json.loads(gzip.decompress(base64.b64decode(packed[1])))
    assert options["truths"]["default"]["picture"].startswith("data:image/png") and options["size"] == [64, 36]


def test_what_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ".html" in refused(capsys, "view", "-o", tmp_path / "a.png")
    np.save(tmp_path / "v.npy", np.zeros(3))
    assert "v.npy" in refused(capsys, "view", tmp_path / "v.npy", "-o", tmp_path / "a.html")
    assert not (tmp_path / "a.html").exists()
