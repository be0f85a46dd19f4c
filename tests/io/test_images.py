"""Reading and writing pictures and arrays."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from PIL import Image

from ssao_gl.errors import FormatError
from ssao_gl.io import images
from ssao_gl.io.atomic import atomic_write

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3), (5, 7, 4), (1, 1), (1, 9, 3)])
def test_png_round_trip(shape: tuple[int, ...], tmp_path: Path) -> None:
    array = RNG.integers(0, 256, shape).astype(np.uint8)
    images.save_image(tmp_path / "a.png", array, texts={"key": "value", "umlaut": "ä"})
    loaded = images.load_image(tmp_path / "a.png")
    assert loaded.dtype == np.uint8 and np.array_equal(loaded, array)
    with Image.open(tmp_path / "a.png") as image:
        assert image.info["key"] == "value" and image.info["umlaut"] == "ä"


def test_16_bits(tmp_path: Path) -> None:
    array = RNG.integers(0, 65536, (4, 6)).astype(np.uint16)
    images.save_image(tmp_path / "a.png", array)
    loaded = images.load_image(tmp_path / "a.png")
    assert loaded.dtype == np.uint16 and np.array_equal(loaded, array)
    with pytest.raises(FormatError, match="16-bit PNG is for grey"):
        images.save_image(tmp_path / "b.png", np.zeros((4, 6, 3), np.uint16))
    assert not (tmp_path / "b.png").exists()


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint8, np.int32, bool])
def test_npy_round_trip(dtype: Any, tmp_path: Path) -> None:
    array = (RNG.random((3, 4, 2)) * 5).astype(dtype)
    images.save_image(tmp_path / "a.npy", array)
    loaded = images.load_image(tmp_path / "a.npy")
    assert loaded.dtype == array.dtype and np.array_equal(loaded, array)
    assert loaded.flags.writeable and not isinstance(loaded, np.memmap), "no longer tied to the file"
    np.save(tmp_path / "f.npy", np.asfortranarray(array))
    assert np.array_equal(images.load_image(tmp_path / "f.npy"), array)


@pytest.mark.parametrize("shape", [(4, 5), (4, 5, 3), (4, 5, 4)])
def test_exr_round_trip(shape: tuple[int, ...], tmp_path: Path) -> None:
    array = RNG.random(shape).astype(np.float32) * 100
    images.save_image(tmp_path / "a.exr", array)
    loaded = images.load_image(tmp_path / "a.exr")
    assert loaded.dtype == np.float32 and np.array_equal(loaded, array)


@given(npst.arrays(np.float32, (3, 4), elements=st.floats(width=32)))
@settings(max_examples=50, deadline=None)
def test_any_number_becomes_a_byte(values: np.ndarray) -> None:
    for bits, top in ((8, 255), (16, 65535)):
        found = images.to_bytes(values, bits)
        expected = np.clip(np.where(np.isnan(values), 0, values).astype(np.float64), 0, 1) * top
        assert np.abs(found - expected).max() <= 0.51


def test_flipped() -> None:
    array = np.arange(12).reshape(4, 3)
    assert images.flipped(array)[0].tolist() == [9, 10, 11] and images.flipped(array).flags.c_contiguous


@pytest.mark.parametrize("mode", ["1", "P", "LA", "PA", "CMYK", "YCbCr", "HSV"])
def test_modes_of_pillow(mode: str, tmp_path: Path) -> None:
    image = (
        Image.fromarray(RNG.integers(0, 256, (4, 6, 4)).astype(np.uint8)).convert("RGB").convert(mode if mode != "PA" else "P")
    )
    name = "a.tif" if mode in ("CMYK", "YCbCr") else "a.png"
    if mode in ("HSV", "PA"):
        image = image.convert("RGBA")
    image.save(tmp_path / name)
    loaded = images.load_image(tmp_path / name)
    assert loaded.dtype == np.uint8 and loaded.shape[:2] == (4, 6) and loaded.shape[2] in (3, 4)


def test_no_programs_are_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pillow would hand EPS to Ghostscript."""

    def fail(*_: object, **__: object) -> None:
        raise AssertionError("a program was started")

    monkeypatch.setattr(subprocess, "Popen", fail)
    path = tmp_path / "a.png"
    path.write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n%%EOF\n")
    with pytest.raises(FormatError, match="not a readable picture"):
        images.load_image(path)


def test_pictures_of_absurd_size(tmp_path: Path) -> None:
    """A few bytes that claim 4 billion pixels; Pillow's own limit is left as it was."""
    import struct
    import zlib

    before = Image.MAX_IMAGE_PIXELS
    head = struct.pack(">IIBBBBB", 1 << 16, 1 << 16, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + b"IHDR" + head + struct.pack(">I", zlib.crc32(b"IHDR" + head))
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk)
    with pytest.raises(FormatError, match="not a readable picture"):
        images.load_image(tmp_path / "a.png")
    assert before == Image.MAX_IMAGE_PIXELS


@pytest.mark.parametrize("suffix", ["png", "npy", "exr"])
def test_truncated(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{suffix}"
    images.save_image(path, RNG.random((40, 50)).astype(np.float32))
    whole = path.read_bytes()
    for share in (0.001, 0.1, 0.5, 0.9):
        path.write_bytes(whole[: max(1, int(len(whole) * share))])
        with pytest.raises(FormatError) as raised:
            images.load_image(path)
        assert str(path) in str(raised.value) and "\n" not in str(raised.value)


def test_unknown_suffix(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"suffix '\.bmp'; use one of \.png, \.npy, \.exr, or a folder"):
        images.save_image(tmp_path / "a.bmp", np.zeros((2, 2), np.uint8))


# Files.


def test_encoder_errors_are_ours(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"cannot write .*a\.webp"), atomic_write(tmp_path / "a.webp") as temporary:
        Image.new("RGB", (20000, 1)).save(temporary, format="WEBP")
    assert not list(tmp_path.iterdir())
