"""The working folder of a tiled picture: what is in it survives, what is foreign or damaged does not."""

from __future__ import annotations

import json
import os
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

from ssao_gl.errors import FormatError
from ssao_gl.tiling import canvas as module
from ssao_gl.tiling.canvas import TileCanvas
from ssao_gl.tiling.layout import Layout

SIZE = (40, 50)
TILES = Layout(SIZE, (16, 32), 0, 0).tiles()
WHOLE = {
    "a": np.arange(2000, dtype=np.float32).reshape(50, 40),
    "b": np.arange(6000).reshape(50, 40, 3).astype(np.uint8),
}


def piece(index: int) -> dict[str, np.ndarray]:
    inner = TILES[index].inner
    top = SIZE[1] - inner.y - inner.h
    return {name: array[top : top + inner.h, inner.x : inner.x + inner.w] for name, array in WHOLE.items()}


def filled(folder: Path, identity: str, until: int) -> list[int]:
    """Add tiles up to ``until``; gives the ones that were missing."""
    with TileCanvas(folder, SIZE, identity) as made:
        missing = list(range(made.done, until))
        for index in missing:
            made.notes = {"last": index}
            made.add(TILES[index].inner, piece(index))
    return missing


def test_tiles_become_the_whole(tmp_path: Path) -> None:
    folder = tmp_path / "w"
    assert filled(folder, "x", len(TILES)) == list(range(6))
    with TileCanvas(folder, SIZE, "x") as made:
        assert made.done == len(TILES) and made.notes == {"last": 5}
        for name, array in WHOLE.items():
            np.testing.assert_array_equal(np.concatenate(list(made.bands(name))), array)
            np.testing.assert_array_equal(np.load(made.path(name)), array)
        made.remove()
    assert not folder.exists()


def test_the_file_is_what_numpy_writes(tmp_path: Path) -> None:
    filled(tmp_path / "w", "x", len(TILES))
    for name, array in WHOLE.items():
        np.save(tmp_path / "expected.npy", array)
        assert (tmp_path / "w" / f"{name}.npy").read_bytes() == (tmp_path / "expected.npy").read_bytes()


def test_bands_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    filled(tmp_path / "w", "x", len(TILES))
    monkeypatch.setattr(module, "BAND_BYTES", 1000)
    with TileCanvas(tmp_path / "w", SIZE, "x") as made:
        bands = list(made.bands("a"))
        assert {len(band) for band in bands} == {6, 2} and made.band("a") == 6
        np.testing.assert_array_equal(np.concatenate(bands), WHOLE["a"])


def test_it_goes_on_where_it_stopped(tmp_path: Path) -> None:
    assert filled(tmp_path / "w", "x", 2) == [0, 1]
    assert filled(tmp_path / "w", "x", 6) == [2, 3, 4, 5]
    with TileCanvas(tmp_path / "w", SIZE, "x") as made:
        np.testing.assert_array_equal(np.load(made.path("a")), WHOLE["a"])


@pytest.mark.parametrize(
    "damage", ["identity", "array gone", "array short", "state gone", "state torn", "state a list", "state too deep"]
)
def test_another_picture_and_damage_begin_anew(tmp_path: Path, damage: str) -> None:
    folder = tmp_path / "w"
    filled(folder, "x", 3)
    state = folder / module.STATE
    if damage == "array gone":
        (folder / "a.npy").unlink()
    elif damage == "array short":
        os.truncate(folder / "b.npy", 1000)
    elif damage == "state gone":
        state.unlink()
    elif damage == "state torn":
        state.write_text(state.read_text()[:-20])
    elif damage == "state a list":
        state.write_text("[]")
    elif damage == "state too deep":
        state.write_text("[" * 100_000)
    identity = "y" if damage == "identity" else "x"
    assert filled(folder, identity, 6) == [0, 1, 2, 3, 4, 5]
    np.testing.assert_array_equal(np.load(folder / "b.npy"), WHOLE["b"])


def test_nothing_stays_when_nothing_was_drawn(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), TileCanvas(tmp_path / "w", SIZE, "x"):
        raise RuntimeError
    assert not (tmp_path / "w").exists()


def test_a_tile_counts_when_it_is_all_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that fills up in the middle of a tile: one line, and the tiles before are kept."""
    filled(tmp_path / "w", "x", 2)
    put = TileCanvas._put

    def full(self: TileCanvas, name: str, *rest: object) -> None:
        if name == "b":
            raise OSError(28, "No space left on device")
        put(self, name, *rest)  # type: ignore[arg-type]

    with monkeypatch.context() as patch, pytest.raises(FormatError, match="No space left on device; the 2 tiles before"):
        patch.setattr(TileCanvas, "_put", full)
        filled(tmp_path / "w", "x", 6)
    assert json.loads((tmp_path / "w" / module.STATE).read_text())["done"] == 2
    assert filled(tmp_path / "w", "x", 6) == [2, 3, 4, 5]


def test_room_is_asked_for_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(module.shutil, "disk_usage", lambda path: usage(10**6, 10**6 - 5000, 5000))
    with pytest.raises(FormatError, match=r"40x50 pixels take .* GiB .* are free"):
        filled(tmp_path / "w", "x", 6)
    assert not (tmp_path / "w").exists()


def test_one_process_at_a_time(tmp_path: Path) -> None:
    with TileCanvas(tmp_path / "w", SIZE, "x") as made:
        made.add(TILES[0].inner, piece(0))
        with pytest.raises(FormatError, match="another run is writing there now"):
            TileCanvas(tmp_path / "w", SIZE, "x")
    assert filled(tmp_path / "w", "x", 2) == [1]


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot make the folder"):
        TileCanvas(tmp_path / "file" / "w", SIZE, "x")
