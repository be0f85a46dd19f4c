"""NRRD and NIfTI files as their programs write them, and as nobody should."""

from __future__ import annotations

import bz2
import gzip
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SceneError
from ssao_gl.loaders.load import load_scene
from ssao_gl.loaders.read_options import VolumeOptions
from ssao_gl.loaders.transfer_files import PRESETS, load_transfer

nibabel = pytest.importorskip("nibabel")
nrrd = pytest.importorskip("nrrd")

VALUES = np.arange(24, dtype=np.uint16).reshape(4, 3, 2).T  # (2, 3, 4), x fastest in the file
LEVEL = VolumeOptions(iso=10.0)
RAW = VALUES.T.tobytes()
HEAD = "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 2 3 4\nendian: little\n"


def volume(path: Path, options: VolumeOptions = LEVEL) -> ao.Volume:
    (found,) = load_scene(path, volume=options).volumes
    return found


def attached(path: Path, fields: str = "encoding: raw\n", data: bytes = RAW, head: str = HEAD) -> Path:
    path.write_bytes((head + fields + "\n").encode() + data)
    return path


@pytest.mark.parametrize(
    ("encoding", "data"),
    [
        ("raw", RAW), ("gzip", gzip.compress(RAW, mtime=0)), ("gz", gzip.compress(RAW, mtime=0)), ("bzip2", bz2.compress(RAW)),
        ("ascii", " ".join(map(str, VALUES.T.ravel())).encode()),
    ],
)  # fmt: skip
@pytest.mark.parametrize("beside", [False, True], ids=["attached", "detached"])
def test_nrrd_encodings(encoding: str, data: bytes, beside: bool, tmp_path: Path) -> None:
    if beside:
        (tmp_path / "a.raw").write_bytes(data)
        path = attached(tmp_path / "a.nhdr", f"encoding: {encoding}\ndata file: ./a.raw\n", b"")
    else:
        path = attached(tmp_path / "a.nrrd", f"encoding: {encoding}\n", data)
    found = volume(path)
    assert np.array_equal(found.array, VALUES) and np.array_equal(found.affine, np.eye(4)) and found.iso == 10


def test_nrrd_big_endian_skips_and_spacings(tmp_path: Path) -> None:
    (tmp_path / "a.raw").write_bytes(b"one line\n12345" + VALUES.T.astype(">u2").tobytes())
    head = HEAD.replace("little", "big")
    path = attached(
        tmp_path / "a.nhdr", "encoding: raw\nline skip: 1\nbyte skip: 5\nspacings: 0.5 2 3\ndata file: a.raw\n", b"", head
    )
    found = volume(path)
    assert np.array_equal(found.array, VALUES) and np.array_equal(np.diag(found.affine), [0.5, 2, 3, 1])
    (tmp_path / "a.raw").write_bytes(b"a header of its own" + VALUES.T.astype(">u2").tobytes())
    path = attached(tmp_path / "a.nhdr", "encoding: raw\nbyte skip: -1\ndata file: a.raw\n", b"", head)
    assert np.array_equal(volume(path).array, VALUES)


@pytest.mark.parametrize(
    ("space", "signs"),
    [("left-posterior-superior", (-1, -1, 1)), ("LPS", (-1, -1, 1)), ("left-anterior-superior", (-1, 1, 1)), ("right-anterior-superior", (1, 1, 1))],
)  # fmt: skip
def test_anatomical_spaces_become_ras(space: str, signs: tuple[int, int, int], tmp_path: Path) -> None:
    """The same patient by NRRD in any space and by NIfTI: the same world."""
    ras = np.array([[2.0, 0.1, 0, -7], [0, 3, 0.2, 5], [0.1, 0, 4, 1], [0, 0, 0, 1]])
    own = np.diag([*signs, 1]) @ ras
    directions = " ".join("(" + ",".join(f"{v:g}" for v in own[:3, axis]) + ")" for axis in range(3))
    origin = ",".join(f"{v:g}" for v in own[:3, 3])
    fields = f"encoding: raw\nspace: {space}\nspace directions: {directions}\nspace origin: ({origin})\n"
    by_nrrd = volume(attached(tmp_path / "a.nrrd", fields))
    nibabel.save(nibabel.Nifti1Image(VALUES, ras), tmp_path / "a.nii.gz")
    by_nifti = volume(tmp_path / "a.nii.gz")
    np.testing.assert_allclose(by_nrrd.affine, ras, atol=1e-12)
    np.testing.assert_allclose(by_nifti.affine, ras, atol=1e-6)
    assert np.array_equal(by_nrrd.array, by_nifti.array)
    assert load_scene(tmp_path / "a.nii.gz", volume=LEVEL).up == (0, 0, 1)


def test_nifti_is_scaled_as_its_header_says(tmp_path: Path) -> None:
    image = nibabel.Nifti1Image(VALUES.astype(np.int16), np.eye(4))
    image.header.set_slope_inter(0.5, 100)
    image = nibabel.Nifti1Image(VALUES * 0.5 + 100, np.eye(4), image.header)
    image.set_data_dtype(np.int16)
    for name in ("a.nii", "a.nii.gz"):
        nibabel.save(image, tmp_path / name)
        np.testing.assert_allclose(volume(tmp_path / name, VolumeOptions(iso=105.0)).array, VALUES * 0.5 + 100, atol=2e-3)


def test_frames_of_a_series_are_chosen(tmp_path: Path) -> None:
    series = np.stack([VALUES, VALUES[::-1]], -1)
    nibabel.save(nibabel.Nifti1Image(series, np.eye(4)), tmp_path / "a.nii.gz")
    nrrd.write(
        str(tmp_path / "a.nrrd"),
        np.moveaxis(series, -1, 0),
        {"space directions": np.array([[np.nan] * 3, *np.eye(3)]), "space": "RAS"},
    )
    for name in ("a.nii.gz", "a.nrrd"):
        for frame in (0, 1):
            assert np.array_equal(volume(tmp_path / name, VolumeOptions(iso=10.0, frame=frame)).array, series[..., frame])
        with pytest.raises(SceneError, match=r"2 frames.*choose one by --frame 0 to 1"):
            volume(tmp_path / name)
        with pytest.raises(SceneError, match="--frame 2 must be 0 to 1"):
            volume(tmp_path / name, VolumeOptions(frame=2))


def test_without_a_level_one_is_found_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    scene = load_scene(attached(tmp_path / "a.nrrd"))
    assert "by Otsu's method" in scene.warnings[0] and "--iso" in caplog.text


def test_gaps_are_counted(tmp_path: Path) -> None:
    data = VALUES.astype(np.float32)
    data[0, 0, 0] = np.nan
    nibabel.save(nibabel.Nifti1Image(data, np.eye(4)), tmp_path / "a.nii")
    scene = load_scene(tmp_path / "a.nii", volume=LEVEL)
    assert scene.warnings == ("1 of 24 voxels are not finite numbers; taken as empty",)


@pytest.mark.parametrize(
    ("fields", "data", "told"),
    [
        ("encoding: raw\n", RAW[:-1], "is cut short: 2 x 3 x 4 voxels of ushort need 48 bytes of data, there are 47"),
        ("encoding: gzip\n", gzip.compress(RAW[:-2], mtime=0), "need 48 bytes of data, there are 46"),
        ("encoding: gzip\n", gzip.compress(RAW, mtime=0)[:-20], "damaged"),
        ("encoding: gzip\n", b"no gzip at all", "damaged"),
        ("encoding: hex\n", b"", "encoding 'hex' is not read"),
        ("encoding: raw\nkinds: RGB-color domain domain\n", RAW, "colours or vectors"),
        ("encoding: raw\ndata file: ../a.raw\n", b"", "outside the header's folder"),
        ("encoding: raw\ndata file: /etc/passwd\n", b"", "outside the header's folder"),
        ("encoding: raw\ndata file: gone.raw\n", b"", "is not there"),
        ("encoding: raw\ndata file: LIST\n", b"", "several files"),
        ("encoding: raw\ndata file: a%03d.raw 1 9 1\n", b"", "several files"),
        ("encoding: raw\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n", RAW, "singular"),
        ("encoding: ascii\n", b"1 2 3 four", ""),
        ("", RAW, "lacks 'encoding'"),
    ],
)  # fmt: skip
def test_broken_nrrd_files_get_one_line(fields: str, data: bytes, told: str, tmp_path: Path) -> None:
    _refused(attached(tmp_path / "a.nrrd", fields, data), told)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("ushort", "block", "type 'block' is not read"),
        ("endian: little\n", "", "lacks 'endian'"),
        ("2 3 4", "2 3 0", "each at least 1"),
        ("2 3 4", "2 3", "expected as many"),
        ("2 3 4", "99999 99999 99999", "at most 2,147,483,648 are drawn"),
        ("dimension: 3\nsizes: 2 3 4", "dimension: 2\nsizes: 4 6", "has 2 axes"),
        ("dimension: 3\nsizes: 2 3 4", "dimension: 5\nsizes: 1 1 2 3 4", "has 5 axes"),
        ("NRRD0004", "NOTNRRD", ""),
    ],
)
def test_broken_nrrd_headers_get_one_line(old: str, new: str, told: str, tmp_path: Path) -> None:
    _refused(attached(tmp_path / "a.nrrd", head=HEAD.replace(old, new)), told)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda data: data[:200], ""),
        (lambda data: data[:-5], "is cut short"),
        (lambda data: b"\0" * len(data), ""),
        (lambda data: data[:42] + b"\xff\x7f" * 3 + data[48:], ""),
    ],
)
def test_broken_nifti_files_get_one_line(make: Any, told: str, tmp_path: Path) -> None:
    nibabel.save(nibabel.Nifti1Image(VALUES, np.eye(4)), tmp_path / "a.nii")
    path = tmp_path / "b.nii"
    path.write_bytes(make((tmp_path / "a.nii").read_bytes()))
    _refused(path, told)
    packed = tmp_path / "b.nii.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    _refused(packed, "")
    packed.write_bytes(gzip.compress((tmp_path / "a.nii").read_bytes())[:-30])
    _refused(packed, "")


def test_damaged_files_are_read_or_refused_in_a_line(tmp_path: Path) -> None:
    """A few bytes of each file changed, dropped or doubled, headers more than data; the same ones in every run."""
    random = np.random.default_rng(11)
    nibabel.save(nibabel.Nifti1Image(VALUES, np.eye(4)), tmp_path / "a.nii")
    attached(tmp_path / "a.nrrd", "encoding: raw\nspace: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspacings: 1 1 1\n")
    refused = 0
    for name in ("a.nii", "a.nrrd"):
        whole = (tmp_path / name).read_bytes()
        path = tmp_path / f"b{Path(name).suffix}"
        for _ in range(150):
            data = bytearray(whole)
            at, many = int(random.integers(min(len(data), 360))), int(random.integers(1, 9))
            change = bytes(random.integers(0, 256, many, np.uint8))
            data[at : at + many] = [change, b"", bytes(data[at : at + many]) * 2][int(random.integers(3))]
            path.write_bytes(data)
            try:
                assert load_scene(path, volume=LEVEL).volumes
            except SceneError as error:
                assert str(error).startswith(str(path)) and "\n" not in str(error)
                refused += 1
    assert 50 < refused < 300


def test_colours_are_no_volume(tmp_path: Path) -> None:
    rgb = np.zeros((2, 3, 4), [("R", "u1"), ("G", "u1"), ("B", "u1")])
    nibabel.save(nibabel.Nifti1Image(rgb, np.eye(4)), tmp_path / "a.nii.gz")
    _refused(tmp_path / "a.nii.gz", "one real number a voxel")


@pytest.mark.parametrize("name", ["a.nrrd", "a.nii.gz"])
def test_more_voxels_than_memory_holds(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused by the header, before anything is taken."""
    attached(tmp_path / "a.nrrd")
    nibabel.save(nibabel.Nifti1Image(VALUES, np.eye(4)), tmp_path / "a.nii.gz")
    monkeypatch.setattr("ssao_gl.loaders.volume_files.free_memory", lambda: 100.0)
    _refused(tmp_path / name, "has 2 x 3 x 4 voxels, which take 0.0 GiB of memory, but 0.0 GiB are free")


def test_a_level_is_for_volumes_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    with pytest.raises(SceneError, match="is no volume"):
        load_scene(path, volume=LEVEL)


@pytest.mark.parametrize(("package", "name"), [("nrrd", "a.nrrd"), ("nibabel", "a.nii")])
def test_without_the_packages_a_line_says_what_to_install(
    package: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    _refused(attached(tmp_path / name), r"pip install 'ssao_gl[volumes]'")


def _refused(path: Path, told: str) -> None:
    with pytest.raises(SceneError) as error:
        load_scene(path, volume=LEVEL)
    text = str(error.value)
    assert text.startswith(str(path)) and told in text and "\n" not in text and "Traceback" not in text


TOML = """
unit = 2.0
step = 1
[[points]]
value = 100
opacity = 0
color = "#ff0000"
[[points]]
value = 200
opacity = 0.5
"""


def test_transfer_functions_come_from_toml(tmp_path: Path) -> None:
    path = tmp_path / "bone.toml"
    path.write_text(TOML)
    made = load_transfer(str(path))
    assert (made.unit, made.step, made.relative, len(made.points)) == (2.0, 1.0, False, 2)
    assert made.points[0].color == (1, 0, 0) and made.points[1].opacity == 0.5
    assert load_transfer("bone") is PRESETS["bone"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("step = 1", "stpe = 1", "Did you mean 'step'"),
        ("unit = 2.0", "unit = 'two'", "must be a number"),
        ("unit = 2.0", "unit = -1", "above 0"),
        ("value = 100", "worth = 100", "no 'worth'"),
        ("value = 100\n", "", "value=None: must be a number"),
        ("#ff0000", "red", "must look like #rrggbb"),
        ("opacity = 0.5", "opacity = 1.5", "0 to 1"),
        ("value = 200", "value = 50", "must grow"),
        ("value = 200", "value = nan", "finite"),
        ("[[points]]", "[points]", "not a transfer function"),
        ("[[points]]", "[[pints]]", "Did you mean 'points'"),
    ],
)
def test_broken_transfer_functions_get_one_line(old: str, new: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(TOML.replace(old, new))
    with pytest.raises(SceneError) as error:
        load_transfer(str(path))
    assert told in str(error.value) and str(path) in str(error.value) and "\n" not in str(error.value)


def test_a_transfer_function_that_is_not_there() -> None:
    with pytest.raises(SceneError, match=r"bnoe: no such file; expected a TOML file or one of bone.* Did you mean 'bone'"):
        load_transfer("bnoe")
