"""PNG files written in bands: any reader gives back what went in."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from PIL import Image

from ssao_gl.errors import FormatError
from ssao_gl.io import images, png_stream

RNG = np.random.default_rng(3)


def encoded(array: np.ndarray, rows: int, texts: dict[str, str] | None = None) -> bytes:
    out = io.BytesIO()
    bands = (array[top : top + rows] for top in range(0, len(array), rows))
    png_stream.write_png_rows(out, array.shape[1::-1], bands, texts)  # type: ignore[arg-type]
    return out.getvalue()


def decoded(data: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image)


SHAPES = st.tuples(st.integers(1, 9), st.integers(1, 9))
ARRAYS = st.one_of(
    npst.arrays(np.uint8, SHAPES),
    npst.arrays(np.uint16, SHAPES),
    npst.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.sampled_from([3, 4]))),
)


@settings(deadline=None)
@given(ARRAYS, st.integers(1, 10))
def test_round_trip(array: np.ndarray, rows: int) -> None:
    np.testing.assert_array_equal(decoded(encoded(array, rows)), array)


def test_every_filter_is_used_and_undone() -> None:
    """Rows that suit each: noise, a slope along the row, the same row again."""
    noise = RNG.integers(0, 256, 64)
    array = np.stack([noise, np.arange(64) * 3 % 256, np.arange(64) * 3 % 256 + 1, noise]).astype(np.uint8)
    data = encoded(array, 2)
    np.testing.assert_array_equal(decoded(data), array)
    smooth = np.add.outer(np.arange(256), np.arange(256)).astype(np.uint8)
    assert len(encoded(smooth, 100)) < smooth.size / 20, "slopes cost next to nothing"


def test_the_same_picture_and_texts_as_written_whole(tmp_path: Path) -> None:
    array = RNG.integers(0, 256, (30, 20, 3)).astype(np.uint8)
    texts = {"Software": "ssao_gl", "ssao_gl:settings": '{"a": 1}', "umlaut": "ä", "beyond latin": "ε"}
    images.save_image(tmp_path / "whole.png", array, texts=texts)
    (tmp_path / "bands.png").write_bytes(encoded(array, 7, texts))
    with Image.open(tmp_path / "whole.png") as whole, Image.open(tmp_path / "bands.png") as bands:
        assert whole.info == bands.info and whole.mode == bands.mode
        np.testing.assert_array_equal(np.asarray(whole), np.asarray(bands))


def test_the_bytes_depend_on_the_rows_and_not_on_the_bands() -> None:
    array = RNG.integers(0, 4, (40, 50)).astype(np.uint8)
    assert decoded(encoded(array, 3)).tobytes() == decoded(encoded(array, 40)).tobytes()
    assert encoded(array, 7) == encoded(array, 7)


@pytest.mark.parametrize(
    "band",
    [np.zeros((2, 5), np.float32), np.zeros((2, 4), np.uint8), np.zeros((2, 5, 2), np.uint8), np.zeros((2, 5, 3), np.uint16)],
)
def test_bands_that_do_not_fit(band: Any) -> None:
    with pytest.raises(FormatError, match="a band of a PNG 5 pixels wide"):
        png_stream.write_png_rows(io.BytesIO(), (5, 2), [band])


def test_a_wrong_number_of_rows() -> None:
    with pytest.raises(FormatError, match="got 3 rows"):
        png_stream.write_png_rows(io.BytesIO(), (5, 4), [np.zeros((3, 5), np.uint8)])
