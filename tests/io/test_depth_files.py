"""Depth is read from every format, by the names that renderers give to channels."""

from __future__ import annotations

import gzip
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.io.color_files import load_color
from ssao_gl.io.depth_files import as_depth_image, load_depth

Z = (1 + np.arange(12, dtype=np.float32).reshape(3, 4) / 4).astype(np.float32)
MM = (1000 * Z).astype(np.uint16)


def exr(path: Path, **channels: Any) -> Path:
    OpenEXR = pytest.importorskip("OpenEXR")
    held = {name.replace("_", "."): np.ascontiguousarray(values, np.float32) for name, values in channels.items()}
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, held) as file:
        file.write(str(path))
    return path


GREY = {"R": 0.5 + 0 * Z, "G": 0.5 + 0 * Z, "B": 0.25 + 0 * Z}
LAYERS: dict[str, dict[str, Any]] = {
    "Z": {"Z": Z},
    "V": {"V": Z},
    "RGBAZ": {**GREY, "A": 1 + 0 * Z, "Z": Z},
    "multilayer": {
        **{f"ViewLayer_Combined_{name}": 0.5 + 0 * Z for name in "RGBA"},
        **{f"ViewLayer_Normal_{name}": 0 * Z for name in "XYZ"},
        "ViewLayer_Mist_Z": 0 * Z,
        "ViewLayer_Depth_Z": Z,
    },
    "distance": {**GREY, "Depth_V": Z},
    "named": {"depth": Z},
    "luminance": {"Y": Z},
    "thrice": {"R": Z, "G": Z, "B": Z},
    "thrice in a layer": {"Image_R": Z, "Image_G": Z, "Image_B": Z, "Image_A": 1 + 0 * Z},
}


@pytest.mark.parametrize("layers", LAYERS)
def test_exr_channels(layers: str, tmp_path: Path) -> None:
    assert np.array_equal(load_depth(exr(tmp_path / "a.exr", **LAYERS[layers])), Z)


def test_exr_channels_by_name(tmp_path: Path) -> None:
    path = exr(tmp_path / "a.exr", **GREY, far=Z, near=0 * Z)
    with pytest.raises(ao.FormatError, match=r"none of its channels is known as depth \(.*far.*\); name one: --depth-channel"):
        load_depth(path)
    assert np.array_equal(load_depth(path, "far"), Z)
    with pytest.raises(ao.FormatError, match=r"no channel 'fat'.*Did you mean 'far'"):
        load_depth(path, "fat")
    two = exr(tmp_path / "b.exr", A_Z=Z, B_Z=2 * Z)
    with pytest.warns(ao.InputWarning, match="several channels may be depth, A.Z, B.Z: the first is taken"):
        assert np.array_equal(load_depth(two), Z)


def test_npz_by_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", color=np.zeros((3, 4, 3)), depth=Z)
    assert np.array_equal(load_depth(tmp_path / "a.npz"), Z)
    np.savez_compressed(tmp_path / "b.npz", one=0 * Z, two=Z)
    assert np.array_equal(load_depth(tmp_path / "b.npz", "two"), Z)
    with pytest.raises(ao.FormatError, match=r"\(one, two\); name one"):
        load_depth(tmp_path / "b.npz")


@pytest.mark.parametrize("name", ["a.npy", "a.png", "a.tif", "a.pgm"])
def test_millimetres(name: str, tmp_path: Path) -> None:
    if name.endswith("npy"):
        np.save(tmp_path / name, MM)
    else:
        Image.fromarray(MM).save(tmp_path / name)
    found = load_depth(tmp_path / name)
    assert found.dtype == np.uint16 and np.array_equal(found, MM)
    depth = as_depth_image(tmp_path / name, depth_scale=0.001).linear(ao.Camera.perspective(1.0))
    assert np.abs(depth - Z).max() < 1e-6


@pytest.mark.parametrize("kind", [b"P5", b"P2"])
def test_levels_of_other_sensors(kind: bytes, tmp_path: Path) -> None:
    """PGM files of 12 bits hold what they hold."""
    values = np.array([[0, 1, 4095], [2048, 300, 77]], ">u2")
    body = values.tobytes() if kind == b"P5" else b" ".join(str(v).encode() for v in values.ravel())
    (tmp_path / "a.pgm").write_bytes(kind + b"\n# made here\n3 2\n4095\n" + body)
    assert np.array_equal(load_depth(tmp_path / "a.pgm"), values)


@pytest.mark.parametrize("name", ["a.tif", "a.pfm"])
def test_floats(name: str, tmp_path: Path) -> None:
    if name == "a.tif":
        Image.fromarray(Z).save(tmp_path / name)
    else:
        (tmp_path / name).write_bytes(b"Pf\n4 3\n-1.0\n" + Z[::-1].astype("<f4").tobytes())
    assert np.array_equal(load_depth(tmp_path / name), Z)


def test_colour_is_no_depth(tmp_path: Path) -> None:
    rgb = np.stack([MM % 7, MM % 5, MM % 3], -1).astype(np.uint8)
    Image.fromarray(rgb).save(tmp_path / "a.png")
    with pytest.raises(ao.FormatError, match="holds colour, uint8 of shape"):
        load_depth(tmp_path / "a.png")
    Image.fromarray(np.repeat(rgb[..., :1], 3, -1)).save(tmp_path / "b.png")
    assert np.array_equal(load_depth(tmp_path / "b.png"), rgb[..., 0])
    with pytest.raises(ao.FormatError, match="has no channel 'Z' to choose"):
        load_depth(tmp_path / "b.png", "Z")


def test_sizes_are_checked_before_memory_is_taken(tmp_path: Path) -> None:
    header = b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little")
    claim = b"{'descr': '<f4', 'fortran_order': False, 'shape': (200000, 200000), }".ljust(117) + b"\n"
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("depth.npy", header + claim)
    (tmp_path / "a.npy").write_bytes(header + claim)
    (tmp_path / "a.pgm").write_bytes(b"P5 60000 60000 65535\n")
    for name in ("a.npz", "a.npy", "a.pgm"):
        with pytest.raises(ao.FormatError) as error:
            load_depth(tmp_path / name)
        assert "\n" not in str(error.value)


def test_photographs_are_upright(tmp_path: Path) -> None:
    """Orientation 6: the first row of the file is the right side of what is shown."""
    shown = np.zeros((4, 6, 3), np.uint8)
    shown[:, 3:] = [250, 250, 0]
    turned = Image.fromarray(np.ascontiguousarray(np.rot90(shown)))
    tags = Image.Exif()
    tags[0x0112] = 6
    turned.save(tmp_path / "a.png", exif=tags)
    assert np.array_equal(load_color(tmp_path / "a.png"), shown)


def test_colours_become_bytes(tmp_path: Path) -> None:
    Image.fromarray(np.full((2, 3), 200, np.uint8)).save(tmp_path / "a.png")
    assert (load_color(tmp_path / "a.png") == np.full((2, 3, 3), 200)).all()
    Image.fromarray(np.full((2, 3), 200 * 257, np.uint16)).save(tmp_path / "b.png")
    with pytest.warns(ao.InputWarning, match="its 16 bits a channel become 8"):
        assert (load_color(tmp_path / "b.png") == np.full((2, 3, 3), 200)).all()
    np.save(tmp_path / "c.npy", np.ones((2, 3, 3)))
    with pytest.raises(ao.FormatError, match="expected uint8 sRGB colour"):
        load_color(tmp_path / "c.npy")


def test_what_is_said_twice() -> None:
    with pytest.raises(ao.SettingsError, match="is a DepthImage already; say kind there"):
        as_depth_image(ao.DepthImage(Z), depth_kind="eye")
    with pytest.raises(ao.SettingsError, match="for EXR and NPZ files"):
        as_depth_image(Z, depth_channel="Z")
    with pytest.raises(TypeError, match="unexpected keyword argument 'sort'"):
        as_depth_image(Z, depth_sort="eye")  # type: ignore[call-arg]


def test_packed_arrays_as_nerfstudio_leaves_them(tmp_path: Path) -> None:
    depth = np.linspace(1, 2, 12, dtype=np.float32).reshape(3, 4, 1)
    path = tmp_path / "frame_00001.npy.gz"
    with gzip.open(path, "wb") as file:
        np.save(file, depth)
    np.testing.assert_array_equal(load_depth(path), depth)
    with gzip.open(path, "wb") as file:
        np.save(file, np.asfortranarray(depth[..., 0]))
    np.testing.assert_array_equal(load_depth(path), depth[..., 0])
    with gzip.open(path, "wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (1 << 13, 1 << 13)})
    with pytest.raises(ao.FormatError, match="announces more"):
        load_depth(path)
    path.write_bytes(b"no gzip")
    with pytest.raises(ao.FormatError, match="not a readable depth image"):
        load_depth(path)
