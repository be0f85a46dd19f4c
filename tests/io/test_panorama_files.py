"""Pictures of light from all around: Radiance, EXR and 8 bits; broken ones are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ssao_gl.errors import FormatError
from ssao_gl.io.panorama_files import load_panorama

HEAD = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 2 +X 8\n"
PIXELS = np.arange(64, dtype=np.uint8).reshape(2, 8, 4) + np.array([0, 0, 0, 100], np.uint8)


def light() -> np.ndarray:
    return PIXELS[..., :3] * np.ldexp(1.0, PIXELS[..., 3:].astype(int) - 136)


def packed() -> bytes:
    rows = b""
    for row in PIXELS:
        rows += bytes([2, 2, 0, 8])
        for channel in row.T:
            rows += bytes([3]) + channel[:3].tobytes() + bytes([5]) + channel[3:].tobytes()
    return rows


@pytest.mark.parametrize("body", [PIXELS.tobytes(), packed()], ids=["flat", "runs"])
def test_radiance(tmp_path: Path, body: bytes) -> None:
    path = tmp_path / "a.hdr"
    path.write_bytes(HEAD + body)
    np.testing.assert_allclose(load_panorama(path), light())


def test_a_run_repeats(tmp_path: Path) -> None:
    path = tmp_path / "a.hdr"
    row = bytes([2, 2, 0, 8]) + b"".join(bytes([128 + 8, value]) for value in (128, 64, 32, 129))
    path.write_bytes(HEAD + 2 * row)
    np.testing.assert_allclose(load_panorama(path), np.broadcast_to([1.0, 0.5, 0.25], (2, 8, 3)))


def test_eight_bits_are_decoded(tmp_path: Path) -> None:
    Image.fromarray(np.full((4, 8, 3), 188, np.uint8)).save(tmp_path / "a.png")
    np.testing.assert_allclose(load_panorama(tmp_path / "a.png"), 0.5, atol=0.005)


def test_exr(tmp_path: Path) -> None:
    import OpenEXR

    rgb = np.random.default_rng(0).random((4, 8, 3), np.float32) * 9
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": rgb}).write(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(load_panorama(tmp_path / "a.exr"), rgb)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Z": rgb[..., 0].copy()}).write(str(tmp_path / "z.exr"))
    with pytest.raises(FormatError, match="expected R, G and B"):
        load_panorama(tmp_path / "z.exr")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"no picture", "is no Radiance picture"),
        (HEAD + packed()[:-3], "breaks off, in row 1 of 2"),
        (HEAD + bytes([2, 2, 0, 8, 200, 1]), "breaks off, in row 0 of 2"),
        (HEAD.replace(b"-Y 2 +X 8", b"-Y 99999 +X 99999"), "too large"),
    ],
)
def test_broken_ones(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.hdr"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message):
        load_panorama(path)


def test_negative_light(tmp_path: Path) -> None:
    import OpenEXR

    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": np.full((4, 8, 3), -1, np.float32)}).write(str(tmp_path / "a.exr"))
    with pytest.raises(FormatError, match="negative or no number"):
        load_panorama(tmp_path / "a.exr")
