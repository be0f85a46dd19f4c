"""PLY, OBJ, STL and packed files as their programs write them: each quad must come out red."""

from __future__ import annotations

import gzip
import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from ssao_gl.errors import SceneError
from ssao_gl.loaders.load import load_scene
from ssao_gl.scene.model import Scene

from ..colors import colors_at_vertices
from ..scene_files import LIST, XYZ, ply

CORNERS = [(-1, -1, 0), (1, -1, 0), (-1, 1, 0), (1, 1, 0)]
RED = (255, 0, 0)


def is_red(scene: Scene) -> bool:
    (mesh,) = scene.meshes
    return scene.triangles == 2 and bool((colors_at_vertices(mesh)[:, :3] == RED).all())


def painted(names: str, kind: str = "uchar", value: str = "255 0 0") -> bytes:
    colors = "".join(f"property {kind} {name}\n" for name in names.split())
    body = "".join(f"{x} {y} {z} {value}\n" for x, y, z in CORNERS) + "3 0 1 2\n3 1 3 2\n"
    return ply(f"element vertex 4\n{XYZ}\n{colors}element face 2\n{LIST}", body.encode(), "ascii")


@pytest.mark.parametrize(
    "content",
    [
        painted("red green blue"),
        painted("diffuse_red diffuse_green diffuse_blue"),
        painted("r g b"),
        painted("red green blue", "float", "1.0 0 0"),
        painted("red green blue", "ushort", "65535 0 0"),
    ],
    ids=["red", "diffuse_red", "r", "float", "ushort"],
)
@pytest.mark.parametrize("packed", [False, True])
def test_ply_colours(content: bytes, packed: bool, tmp_path: Path) -> None:
    path = tmp_path / ("a.ply.gz" if packed else "a.ply")
    path.write_bytes(gzip.compress(content) if packed else content)
    assert is_red(load_scene(path))


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize(("strips", "expected"), [([[0, 1, 2, 3]], 2), ([[0, 1, 2, -1, 1, 3, 2], [0, 1]], 2)])
def test_ply_strips(form: str, strips: list[list[int]], expected: int, tmp_path: Path) -> None:
    header = f"element vertex 4\n{XYZ}\nelement tristrips {len(strips)}\nproperty list int int vertex_indices"
    if form == "ascii":
        rows = [" ".join(map(str, corner)) for corner in CORNERS] + [f"{len(s)} " + " ".join(map(str, s)) for s in strips]
        body = ("\n".join(rows) + "\n").encode()
    else:
        order = ">" if "big" in form else "<"
        body = np.array(CORNERS, f"{order}f4").tobytes()
        body += b"".join(np.array([len(strip), *strip], f"{order}i4").tobytes() for strip in strips)
    (tmp_path / "a.ply").write_bytes(ply(header, body, form))
    scene = load_scene(tmp_path / "a.ply")
    assert scene.triangles == expected
    np.testing.assert_allclose(scene.bounds, [[-1, -1, 0], [1, 1, 0]])


def test_ply_strips_that_are_torn(tmp_path: Path) -> None:
    header = f"element vertex 4\n{XYZ}\nelement tristrips 2\nproperty list int int vertex_indices"
    body = np.array(CORNERS, "<f4").tobytes() + np.array([4, 0, 1, 2, 3, 9, 1], "<i4").tobytes()
    (tmp_path / "a.ply").write_bytes(ply(header, body))
    with pytest.raises(SceneError, match="ends within strip 1 of 2"):
        load_scene(tmp_path / "a.ply")


def test_ply_points_with_colours(tmp_path: Path) -> None:
    colors = "property uchar red\nproperty uchar green\nproperty uchar blue"
    body = "".join(f"{x} {y} {z} 255 0 0\n" for x, y, z in CORNERS)
    (tmp_path / "a.ply").write_bytes(ply(f"element vertex 4\n{XYZ}\n{colors}", body.encode(), "ascii"))
    (mesh,) = load_scene(tmp_path / "a.ply").meshes
    assert len(mesh.triangles) == 16 and mesh.vertex_colors is not None and (mesh.vertex_colors[:, :3] == RED).all()


OBJ = "mtllib my.mtl\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
OBJ += "usemtl m\nf 1/1 2/2 3/3\nf 2/2 4/4 3/3\n"


@pytest.mark.parametrize(
    "line",
    [
        "map_Kd tex/wood.png",
        "map_kd tex/wood.png",
        "map_Kd -s 1 1 1 -o 0 0 0 tex/wood.png",
        "map_Kd -bm 0.3 -clamp on -s 1 tex/wood.png",
        "map_Kd .\\tex\\wood.png",
        "map_Kd C:\\Users\\x\\tex\\wood.png",
        "map_Kd /home/somebody/tex/wood.png",
        "map_Kd TEX/../tex/Wood.PNG",
    ],
)
def test_mtl_names_of_pictures(line: str, tmp_path: Path) -> None:
    out = io.BytesIO()
    Image.fromarray(np.full((2, 2, 3), RED, np.uint8)).save(out, "PNG")
    (tmp_path / "tex").mkdir()
    (tmp_path / "tex" / "wood.png").write_bytes(out.getvalue())
    (tmp_path / "my.mtl").write_text(f"newmtl m\nKd 1 1 1\n{line}\n")
    (tmp_path / "a.obj").write_text(OBJ)
    scene = load_scene(tmp_path / "a.obj")
    assert is_red(scene) and scene.warnings == ()


def test_mtl_options_that_are_not_applied_are_said(tmp_path: Path) -> None:
    Image.fromarray(np.full((2, 2, 3), RED, np.uint8)).save(tmp_path / "wood.png")
    (tmp_path / "my.mtl").write_text("newmtl m\nmap_Kd -t 2 2 wood.png\n")
    (tmp_path / "a.obj").write_text(OBJ)
    assert load_scene(tmp_path / "a.obj").warnings == ("a picture's option -t in the material library is not applied",)


def test_materials_beside_a_packed_file(tmp_path: Path) -> None:
    (tmp_path / "my.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (tmp_path / "a.obj.gz").write_bytes(gzip.compress(OBJ.encode()))
    assert is_red(load_scene(tmp_path / "a.obj.gz"))


@pytest.mark.parametrize(
    ("header", "word"), [(b"", 0xFC00), (b"COLOR=\xff\xff\xff\xff", 0x001F), (b"COLOR=\xff\x00\x00\xff", 0x8000)]
)
def test_stl_colours(header: bytes, word: int, tmp_path: Path) -> None:
    """As VisCAM and Magics write them; the last has the colour of the whole."""
    triangles = [(CORNERS[0], CORNERS[1], CORNERS[2]), (CORNERS[1], CORNERS[3], CORNERS[2])]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), word) for t in triangles)
    (tmp_path / "a.stl").write_bytes(header.ljust(80, b"\0") + struct.pack("<I", 2) + body)
    assert is_red(load_scene(tmp_path / "a.stl"))


def test_nothing_can_be_seen(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "a.off").write_text("OFF\n3 1 0\n1 2 3\n1 2 3\n1 2 3\n3 0 1 2\n")
    with caplog.at_level("WARNING"):
        scene = load_scene(tmp_path / "a.off")
    assert scene.warnings == ("nothing can be seen: none of its triangles has an area",)
    assert "nothing can be seen" in caplog.text and scene.default_camera() and scene.default_radius() > 0


def quad_obj(folder: Path, library: str, **pictures: Any) -> Scene:
    """A quad of two triangles with a material library and pictures beside it."""
    for name, texels in pictures.items():
        Image.fromarray(np.asarray(texels, np.uint8)).save(folder / f"{name}.png")
    (folder / "m.mtl").write_text("newmtl m\n" + library)
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    (folder / "quad.obj").write_text(
        f"mtllib m.mtl\nusemtl m\n{corners}vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/2 4/4 3/3\n"
    )
    return load_scene(folder / "quad.obj")


@pytest.mark.parametrize(
    ("line", "alpha"),
    [("d 0.4", 0.4), ("Tr 0.3", 0.7), ("d -halo 0.8", 0.8), ("d 1", 1), ("Tr 0", 1), ("d 0.9\nTr 0.8", 0.9), ("d x", 1)],
)
def test_dissolve_is_alpha(tmp_path: Path, line: str, alpha: float) -> None:
    """Below one half nothing is drawn, and it is said."""
    scene = quad_obj(tmp_path, f"Kd 1 0 0\n{line}\n")
    (mesh,) = scene.meshes
    assert mesh.material is not None and mesh.material.base_color[3] == pytest.approx(alpha)
    assert bool(scene.drawn) == (alpha >= 0.5)
    assert any("transparent" in line for line in scene.warnings) == (alpha < 1)


def test_wholly_transparent_is_taken_for_a_mistake(tmp_path: Path) -> None:
    """Exporters that mean the opposite are as frequent as invisible materials are useless."""
    for line in ("d 0", "Tr 1"):
        scene = quad_obj(tmp_path, f"Kd 1 0 0\n{line}\n")
        assert scene.drawn and is_red(scene) and "drawn solid" in scene.warnings[0]


@pytest.mark.parametrize("kind", ["grey", "alpha"])
def test_map_d_cuts_out(tmp_path: Path, kind: str) -> None:
    shape = np.zeros((8, 8), np.uint8)
    shape[2:6, 2:6] = 255
    cut = shape if kind == "grey" else np.dstack([np.full((8, 8, 3), 90, np.uint8), shape])
    scene = quad_obj(tmp_path, "map_Kd wood.png\nmap_d cut.png\n", wood=np.full((4, 4, 3), (255, 0, 0)), cut=cut)
    (mesh,) = scene.meshes
    assert is_red(scene) and mesh.cutoff == 0.5 and mesh.texture is not None
    assert mesh.texture.array[0, 0, 3] == 0 and mesh.texture.array[2, 2, 3] == 255
    missing = quad_obj(tmp_path, "Kd 1 0 0\nmap_d none.png\n")
    assert missing.drawn and any("none.png" in line for line in missing.warnings)


def test_scale_and_offset_of_a_map_are_applied(tmp_path: Path) -> None:
    """uv x scale + offset, v upwards; -clamp too."""
    (mesh,) = quad_obj(tmp_path, "map_Kd -s 2 3 1 -o 0.25 0.5 -clamp on wood.png\n", wood=np.zeros((4, 4, 3))).meshes
    assert mesh.uv is not None and mesh.texture is not None and mesh.texture.wrap == ("clamp", "clamp")
    assert {tuple(row) for row in mesh.uv.round(6).tolist()} == {(0.25, 0.5), (2.25, 0.5), (0.25, -2.5), (2.25, -2.5)}
