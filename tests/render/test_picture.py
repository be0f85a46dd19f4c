"""What a picture says of itself."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao


@pytest.fixture(scope="module")
def picture(any_renderer: ao.Renderer, embedded: ao.Scene) -> ao.Picture:
    return any_renderer.render(embedded, size=(64, 48), aovs="image,visibility,depth")


def test_repr_is_one_line(picture: ao.Picture) -> None:
    assert repr(picture).startswith("<Picture 64x48: image, visibility, depth, bitmask, embedded scene, ")
    assert "\n" not in repr(picture) and len(repr(picture)) < 160
    assert repr(ao.Picture({})) == "<Picture 0x0: nothing>"
    hostile = ao.Picture({"depth": np.ones((3, 4), np.float32)}, {"scene": "a\nb\x1b[31m" + 900 * "x"})
    assert "\n" not in repr(hostile) and "\x1b" not in repr(hostile) and len(repr(hostile)) < 160


def test_html_shows_picture_visibility_and_settings(picture: ao.Picture) -> None:
    page = picture._repr_html_()
    shown = re.findall(r'src="data:image/png;base64,([A-Za-z0-9+/=]+)" alt="(\w+)"', page)
    assert [name for _, name in shown] == ["image", "visibility"]
    image, visibility = (np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))) for data, _ in shown)
    assert np.array_equal(image, picture.image) and np.array_equal(visibility, picture.as_png("visibility"))
    for name in ("bitmask.steps", "blur", "shading.ambient", "provider"):
        assert f">{name}</th>" in page
    assert not re.search(r'(?:src|href)="(?!data:)', page) and "<script" not in page


def test_html_escapes_what_names_hold() -> None:
    report = {"scene": "<script>alert(1)</script>", "settings": {"method": "<b>", "<i>": {"<u>": "&"}}}
    page = ao.Picture({"depth": np.ones((3, 4), np.float32)}, report)._repr_html_()
    assert not re.search("<(script|b|i|u)>", page) and "&lt;script&gt;" in page and 'alt="depth"' in page


def test_html_of_large_pictures_is_small() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (1500, 3000, 3), np.uint8)
    assert len(ao.Picture({"image": noise})._repr_html_()) < 4 << 20
