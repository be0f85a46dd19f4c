"""What is read from mesh files: geometry, instances, transforms, colours, normals, cameras."""

from __future__ import annotations

import json
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from ssao_gl.errors import SceneError
from ssao_gl.loaders.as_scene import as_camera
from ssao_gl.loaders.load import load_scene as load_mesh_file
from ssao_gl.loaders.trimesh_scenes import from_trimesh
from ssao_gl.scene.lens import Orthographic, Perspective
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.srgb import encode
from ssao_gl.scene.vertex_normals import crease_normals, weld

from ..colors import colors_at_vertices
from ..scene_files import binary, glb, tree, zipped

SUFFIXES = ["glb", "obj", "ply", "stl", "off"]


def written(folder: Path, mesh: Any, suffix: str, **options: Any) -> Path:
    path = folder / f"scene.{suffix}"
    mesh.export(path, **options)
    return path


def one(scene: Scene) -> Mesh:
    assert len(scene.meshes) == 1
    return scene.meshes[0]


def corners(draw: Mesh) -> np.ndarray:
    """World coordinates (k m, 3, 3) of all triangles of all instances."""
    points = np.einsum("kij,nj->kni", draw.transforms[:, :3, :3], draw.positions) + draw.transforms[:, None, :3, 3]
    return points[:, draw.triangles].reshape(-1, 3, 3)


def sorted_rows(triangles: np.ndarray) -> np.ndarray:
    centers = np.round(triangles.mean(1), 4)
    return centers[np.lexsort(centers.T)]


@pytest.mark.parametrize("suffix", [*SUFFIXES, "zip"])
def test_formats(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.creation.icosphere(3)
    mesh.apply_scale([1, 1.5, 2])
    if suffix == "zip":
        path = tmp_path / "scene.zip"
        path.write_bytes(zipped(a__stl=mesh.export(file_type="stl")))
    else:
        path = written(tmp_path, mesh, suffix)
    scene = load_mesh_file(path)
    draw = one(scene)
    assert scene.triangles == len(mesh.faces)
    assert len(draw.positions) == len(mesh.vertices), "smooth: no vertex is doubled, none is left apart"
    np.testing.assert_allclose(scene.bounds, mesh.bounds, atol=1e-6)
    np.testing.assert_allclose(sorted_rows(corners(draw)), sorted_rows(mesh.triangles), atol=2e-4)
    assert draw.normals is not None
    outward = np.einsum("ij,ij->i", draw.normals, draw.positions / np.array([1, 2.25, 4]))
    assert outward.min() > 0, "the gradient of the ellipsoid"
    assert scene.name == path.name


@pytest.mark.parametrize(("suffix", "up"), [("glb", 1), ("obj", 1), ("ply", 2), ("stl", 2), ("off", 2)])
def test_up_axis(suffix: str, up: int, tmp_path: Path) -> None:
    path = written(tmp_path, trimesh.creation.box(), suffix)
    assert np.argmax(load_mesh_file(path).up) == up
    assert load_mesh_file(path, up="x").up == (1, 0, 0)
    with pytest.raises(SceneError, match="up axis 'w'; must be"):
        load_mesh_file(path, up="w")


def test_obj_indices_that_count_back(tmp_path: Path) -> None:
    """From the vertices read so far, not from the last of the file; also those of normals and texture coordinates."""
    quads = [[(0, 0, z), (1, 0, z), (1, 1, z), (0, 1, z)] for z in range(3)]
    lines = ["o first"]
    for number, quad in enumerate(quads):
        lines += [f"v {x} {y} {z}" for x, y, z in quad] + [f"vt {number} 0", f"vn 0 0 {(-1) ** number}"]
        lines += [f"usemtl m{number}", "f -4/-1/-1 -3/-1/-1 \\", "  -2/-1/-1 -1/-1/-1  # the latest four"]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    scene = load_mesh_file(tmp_path / "a.obj")
    assert scene.triangles == 6
    found = np.concatenate([corners(draw) for draw in scene.meshes])
    np.testing.assert_array_equal(np.unique(found[:, :, 2]), [0, 1, 2])
    assert (np.ptp(found[:, :, 2], axis=1) == 0).all()
    normals = {float(draw.positions[0, 2]): draw.normals for draw in scene.meshes}
    assert all(n is not None and (n[:, 2] == (-1) ** int(z)).all() for z, n in normals.items())


@pytest.mark.parametrize(("order", "name"), [("<", "little"), (">", "big")])
def test_binary_ply_of_triangles_quads_and_more(order: str, name: str, tmp_path: Path) -> None:
    """Polygons are cut into fans; what else vertices and faces carry stays, or is left out."""
    corners_ = [(0, 0), (2, 0), (3, 1), (2, 2), (0, 2), (-1, 1)]
    polygons = [(0, 1, 2, 3, 4, 5), (0, 1, 3), (0, 1, 3, 4), (2, 3), (5, 0, 4)]
    header = f"""ply
format binary_{name}_endian 1.0
element vertex 6
property double x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face {len(polygons)}
property uchar flags
property list ushort uint vertex_indices
property float quality
end_header
"""
    body = b"".join(struct.pack(f"{order}dffBBB", x, y, 0, 255, 0, 0) for x, y in corners_)
    body += b"".join(struct.pack(f"{order}BH{len(p)}If", 7, len(p), *p, 0.5) for p in polygons)
    (tmp_path / "a.ply").write_bytes(header.encode() + body)
    draw = one(load_mesh_file(tmp_path / "a.ply"))
    sides = np.diff(corners(draw)[:, :, :2], axis=1)
    areas = (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    assert len(areas) == 4 + 1 + 2 + 1
    assert np.abs(areas).sum() == pytest.approx(6 + 2 + 4 + 1)
    assert draw.vertex_colors is not None and (draw.vertex_colors[:, :3] == (255, 0, 0)).all()


def test_upper_case_suffix(tmp_path: Path) -> None:
    written(tmp_path, trimesh.creation.box(), "stl").rename(tmp_path / "A.STL")
    assert load_mesh_file(tmp_path / "A.STL").triangles == 12


def test_instances_share_geometry(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    mesh = trimesh.creation.box()
    places = [trimesh.transformations.translation_matrix([3 * k, 0, 0]) for k in range(5)]
    scene.geometry["box"] = mesh
    for k, place in enumerate(places):
        scene.graph.update(frame_to=f"n{k}", matrix=place, geometry="box")
    draw = one(load_mesh_file(written(tmp_path, scene, "glb")))
    assert len(draw.triangles) == 12 and draw.name == "box"
    found = draw.transforms[np.argsort(draw.transforms[:, 0, 3])]
    np.testing.assert_allclose(found, places)


def node_tree(nodes: list[Any]) -> dict[str, Any]:
    return tree(nodes=nodes)


def test_nested_transforms(tmp_path: Path) -> None:
    """Translation x rotation x scale, and matrices, down a chain; each node relative to the one above."""
    half = np.sqrt(0.5)
    nodes = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, half, half], "scale": [2, 2, 2]},
        {"children": [2], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1]},
        {"mesh": 0, "scale": [1, -1, 1]},
    ]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(node_tree(nodes)))
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])
    outer = trimesh.transformations.translation_matrix([1, 2, 3]) @ turn @ np.diag([2, 2, 2, 1.0])
    expected = outer @ trimesh.transformations.translation_matrix([10, 0, 0]) @ np.diag([1, -1, 1, 1.0])
    draw = one(load_mesh_file(path))
    np.testing.assert_allclose(draw.transforms[0], expected, atol=1e-12)
    assert np.linalg.det(draw.transforms[0][:3, :3]) < 0, "a mirror stays one"


@pytest.mark.parametrize(("kind", "dtype"), [(5122, "<i2"), (5123, "<u2"), (5120, "i1"), (5121, "u1")])
def test_positions_as_normalized_integers(kind: int, dtype: str, tmp_path: Path) -> None:
    """As optimised web models have them: the largest integer is 1."""
    most = np.iinfo(dtype).max
    corners_ = np.zeros((3, 8 // np.dtype(dtype).itemsize), dtype)  # padded to rows of 8 bytes
    corners_[1, 0] = corners_[2, 1] = most
    content = tree(nodes=[{"mesh": 0, "scale": [3, 5, 7], "translation": [1, 0, 0]}])
    content["extensionsUsed"] = content["extensionsRequired"] = ["KHR_mesh_quantization"]
    content["accessors"][0] |= {"componentType": kind, "normalized": True}
    content["bufferViews"][0] |= {"byteStride": 8, "byteLength": 24}
    body = corners_.tobytes() + binary()[24:]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content, body))
    np.testing.assert_allclose(load_mesh_file(path).bounds, [[1, 0, 0], [4, 5, 0]], atol=1e-6)


@given(
    rotation=st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
    scale=st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    translation=st.lists(st.floats(-9, 9), min_size=3, max_size=3),
)
@settings(max_examples=30, deadline=None)
def test_any_transform(rotation: list[float], scale: list[float], translation: list[float]) -> None:
    from ssao_gl.loaders.gltf_nodes import local

    x, y, z, w = rotation
    expected = trimesh.transformations.translation_matrix(translation)
    expected = expected @ trimesh.transformations.quaternion_matrix([w, x, y, z]) @ np.diag([*scale, 1])
    np.testing.assert_allclose(local({"rotation": rotation, "scale": scale, "translation": translation}), expected, atol=1e-9)


def test_nodes_of_one_mesh_and_of_several_primitives(tmp_path: Path) -> None:
    primitive = tree()["meshes"][0]["primitives"][0]
    content = tree(
        meshes=[{"primitives": [primitive, primitive], "name": "pair"}],
        nodes=[{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}],
        scenes=[{"nodes": [0, 1]}],
    )
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content))
    scene = load_mesh_file(path)
    assert len(scene.meshes) == 2 and scene.triangles == 4
    for draw in scene.meshes:
        assert sorted(draw.transforms[:, 0, 3]) == [0, 5]


def test_file_without_a_scene_shows_all_roots(tmp_path: Path) -> None:
    content = tree(nodes=[{"mesh": 0}, {"children": [2]}, {"mesh": 0}])
    del content["scenes"], content["scene"]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content))
    assert load_mesh_file(path).triangles == 2


def test_buffers_beside_the_file(tmp_path: Path) -> None:
    """Names with spaces and folders, quoted or not, also in an archive; data URIs."""
    import base64

    (tmp_path / "my data").mkdir()
    (tmp_path / "my data" / "a b.bin").write_bytes(binary())
    for uri in ("my data/a b.bin", "my%20data/a%20b.bin", "my data\\a b.bin", "./my data/a b.bin"):
        text = json.dumps(tree(buffers=[{"byteLength": 48, "uri": uri}]))
        (tmp_path / "a.gltf").write_text(text)
        assert load_mesh_file(tmp_path / "a.gltf").triangles == 1, uri
        with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
            archive.writestr("in/a.gltf", text)
            archive.writestr("in/my data/a b.bin", binary())
            archive.writestr("__MACOSX/in/._a.gltf", b"\0\5\x16\7")
        assert load_mesh_file(tmp_path / "a.zip").triangles == 1, uri
    data = "data:application/octet-stream;base64," + base64.b64encode(binary()).decode()
    (tmp_path / "b.gltf").write_text(json.dumps(tree(buffers=[{"byteLength": 48, "uri": data}])))
    assert load_mesh_file(tmp_path / "b.gltf").triangles == 1


def test_archive_of_several_meshes(tmp_path: Path) -> None:
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(1)
    path = tmp_path / "a.zip"
    path.write_bytes(
        zipped(a__stl=box.export(file_type="stl"), b__stl=box.export(file_type="stl"), c__ply=ball.export(file_type="ply"))
    )
    assert load_mesh_file(path).triangles == 12 + 12 + len(ball.faces)


# Colours: sRGB in 0..1, or bytes at the vertices.


def test_gltf_factors_are_linear(tmp_path: Path) -> None:
    materials = [{"pbrMetallicRoughness": {"baseColorFactor": [0.2140411, 1, 0, 1]}}]
    content = tree(materials=materials)
    content["meshes"][0]["primitives"][0]["material"] = 0
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content))
    assert one(load_mesh_file(path)).color == pytest.approx((0.5, 1, 0), abs=4e-3)
    content["materials"] = [{}]
    path.write_bytes(glb(content))
    assert one(load_mesh_file(path)).color == (1, 1, 1), "glTF's default is white"
    del content["meshes"][0]["primitives"][0]["material"]
    path.write_bytes(glb(content))
    assert one(load_mesh_file(path)).color == pytest.approx((0.8, 0.8, 0.8))


def painted_square() -> trimesh.Trimesh:
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    mesh.visual.vertex_colors = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 99, 199, 255]], np.uint8)
    return mesh


def by_place(draw: Mesh) -> dict[tuple[float, ...], tuple[int, ...]]:
    found = colors_at_vertices(draw)
    return {tuple(map(float, p)): tuple(map(int, c)) for p, c in zip(draw.positions, found, strict=True)}


@pytest.mark.parametrize("suffix", ["glb", "ply", "obj"])
def test_vertex_colors(suffix: str, tmp_path: Path) -> None:
    mesh = painted_square()
    draw = one(load_mesh_file(written(tmp_path, mesh, suffix)))
    colors = np.array(mesh.visual.vertex_colors)
    if suffix == "glb":  # which is linear there
        colors[:, :3] = np.round(encode(colors[:, :3] / 255) * 255)
    expected = {tuple(map(float, p)): tuple(map(int, c)) for p, c in zip(mesh.vertices, colors, strict=True)}
    assert by_place(draw) == expected and draw.color == (1, 1, 1)


def test_vertex_colors_times_material(tmp_path: Path) -> None:
    """COLOR_0 beside a material without a texture."""
    content = tree(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [0, 1, 0, 1]}}])
    content["meshes"][0]["primitives"][0] |= {"material": 0}
    content["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 2
    content["accessors"].append({"bufferView": 2, "componentType": 5121, "normalized": True, "count": 3, "type": "VEC4"})
    content["bufferViews"].append({"buffer": 0, "byteOffset": 48, "byteLength": 12})
    content["buffers"] = [{"byteLength": 60}]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content, binary() + bytes([10, 20, 30, 255] * 3)))
    draw = one(load_mesh_file(path))
    assert draw.color == (1, 1, 1) and draw.vertex_colors is not None, "the factor is in the vertex colours"
    assert draw.vertex_colors.tolist() == [[0, 79, 0, 255]] * 3, "20 / 255 of linear light"


def test_face_colors_stay_apart_at_edges(tmp_path: Path) -> None:
    mesh = trimesh.creation.box()
    colors = np.arange(72).reshape(6, 12)[:, :3].astype(np.uint8)
    side = np.argmax(np.abs(mesh.face_normals) > 0.5, 1) * 2 + (mesh.face_normals.sum(1) > 0)
    mesh.visual.face_colors = np.column_stack([colors[side], np.full(12, 255, np.uint8)])
    for draw in (one(from_trimesh(mesh)), one(load_mesh_file(written(tmp_path, mesh, "ply")))):
        assert len(draw.positions) == 24 and draw.vertex_colors is not None and draw.color == (1, 1, 1)
        found = draw.vertex_colors[draw.triangles]
        assert (found == found[:, :1]).all(), "each face has its own"
        assert len(np.unique(draw.vertex_colors, axis=0)) == 6


def textured_square(image: Image.Image) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image)
    mesh.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], material=material)
    return mesh


def test_textures_are_sampled_at_vertices(tmp_path: Path) -> None:
    """v points upwards in OBJ, downwards in glTF: either way the picture's lower left is at (0, 0)."""
    image = Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]]], np.uint8))
    for suffix in ("glb", "obj"):
        draw = one(load_mesh_file(written(tmp_path, textured_square(image), suffix)))
        found = by_place(draw)
        assert found[0, 0, 0][:3] == (0, 0, 255) and found[1, 0, 0][:3] == (9, 9, 9), suffix
        assert found[0, 1, 0][:3] == (255, 0, 0) and found[1, 1, 0][:3] == (0, 255, 0), suffix


def test_broken_texture_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    image = Image.fromarray(np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8))
    path = written(tmp_path, textured_square(image), "glb")
    data = bytearray(path.read_bytes())
    at = data.find(b"IDAT") + 40
    data[at : at + 200] = bytes(200)
    path.write_bytes(data)
    with caplog.at_level("WARNING"):
        draw = one(load_mesh_file(path))
    assert draw.vertex_colors is None and "drawn without its texture" in caplog.text


def test_obj_materials(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    text = "mtllib my.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 4\n"
    (tmp_path / "a.obj").write_text(text)
    (tmp_path / "my.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    scene = load_mesh_file(tmp_path / "a.obj")
    assert sorted(draw.color for draw in scene.meshes) == [(0, 0, 1), (1, 0, 0)]
    (tmp_path / "my.mtl").unlink()
    with caplog.at_level("WARNING"):
        assert load_mesh_file(tmp_path / "a.obj").triangles == 2
    assert "drawn without 'my.mtl'" in caplog.text


# Normals.


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_cube_keeps_its_edges(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.creation.box()
    draw = one(load_mesh_file(written(tmp_path, mesh, suffix)))
    assert len(draw.positions) == 24 and draw.normals is not None
    np.testing.assert_allclose(np.abs(draw.normals).max(1), 1, atol=1e-6)
    a, b, c = (draw.positions[draw.triangles[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    for k in range(3):
        np.testing.assert_allclose(draw.normals[draw.triangles[:, k]], flat, atol=1e-6)


def test_crease_angle(tmp_path: Path) -> None:
    path = written(tmp_path, trimesh.creation.box(), "ply")
    assert len(one(load_mesh_file(path, crease=np.radians(100))).positions) == 8, "edges of 90 degrees are smooth now"
    assert one(load_mesh_file(path, crease=0)).normals is None


@pytest.mark.parametrize("suffix", ["glb", "ply", "obj"])
def test_file_normals_are_kept(suffix: str, tmp_path: Path) -> None:
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    tilted = np.tile(np.array([[0.6, 0, 0.8]]), (3, 1))
    mesh.vertex_normals = tilted
    options = {"vertex_normal": True} if suffix == "ply" else {"include_normals": True}
    draw = one(load_mesh_file(written(tmp_path, mesh, suffix, **options)))
    assert draw.normals is not None
    np.testing.assert_allclose(draw.normals, tilted, atol=1e-6)


def test_normals_do_not_depend_on_scale() -> None:
    ball = trimesh.creation.icosphere(2)
    positions, triangles = ball.vertices.astype(np.float32), ball.faces.astype(np.uint32)
    expected = crease_normals(positions, triangles, 0.7)[2]
    for scale in (1e-30, 1e-12, 1e12, 1e30):
        np.testing.assert_allclose(crease_normals(positions * np.float32(scale), triangles, 0.7)[2], expected, atol=1e-5)


def test_tip_of_many_faces_is_quick() -> None:
    """Comparing every pair of faces at the tip of a cone would take minutes."""
    import time

    count = 50_000
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], 1)
    positions = np.vstack([[[0, 0, 1]], rim]).astype(np.float32)
    ring = np.arange(count)
    triangles = np.stack([np.zeros(count), 1 + ring, 1 + (ring + 1) % count], 1).astype(np.uint32)
    began = time.perf_counter()
    split, faces, normals, source = crease_normals(positions, triangles, 0.7)
    assert time.perf_counter() - began < 10
    assert source is not None and np.array_equal(split[faces], positions[triangles])
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)


def test_weld() -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [-0.0, 0, 0], [1, 0, 0], [1, 0, 1e-7]], np.float32)
    triangles = np.array([[0, 1, 4], [2, 3, 4]], np.uint32)
    welded, faces, source = weld(positions, triangles)
    assert source is not None and source.tolist() == [0, 1, 4]
    assert welded.tolist() == positions[[0, 1, 4]].tolist() and faces.tolist() == [[0, 1, 2], [0, 1, 2]]
    colors = np.zeros((5, 4), np.uint8)
    colors[3] = 9
    assert len(weld(positions, triangles, colors)[0]) == 4, "another colour is another vertex"
    assert weld(welded, faces)[2] is None


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 7, 300, 20000]))
@settings(max_examples=20, deadline=None)
def test_weld_keeps_every_corner(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    positions = rng.integers(-3, 4, (count, 3)).astype(np.float32) / 4
    triangles = rng.integers(0, count, (count, 3)).astype(np.uint32)
    welded, faces, _ = weld(positions, triangles)
    assert np.array_equal(welded[faces], positions[triangles])
    assert len(np.unique(welded, axis=0)) == len(welded)


def test_instances_of_scale_and_far_coordinates(tmp_path: Path) -> None:
    """Vertices in double precision, far from the origin, keep their shape."""
    rng = np.random.default_rng(3)
    points = rng.random((30, 3)) + [6378137, 0, -4.2e6]
    faces = np.arange(30).reshape(-1, 3)
    draw = one(from_trimesh(trimesh.Trimesh(points, faces, process=False), crease=0))
    world = draw.positions.astype(np.float64) + draw.transforms[0, :3, 3]
    np.testing.assert_allclose(world, points, atol=1e-6)
    near = one(from_trimesh(trimesh.Trimesh(rng.random((30, 3)) + 3, faces, process=False)))
    assert np.array_equal(near.transforms[0], np.eye(4)), "others are left as they are"


def test_points_nobody_names(tmp_path: Path) -> None:
    """Scanners write NaN for what was not seen; only triangles must be finite."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]])
    scene = from_trimesh(trimesh.Trimesh(points, [[0, 1, 2]], process=False))
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    with pytest.raises(SceneError, match="1 of 2 triangles have vertices that are not finite"):
        from_trimesh(trimesh.Trimesh(points, [[0, 1, 2], [0, 1, 3]], process=False))


# Cameras.


def test_gltf_cameras(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """All of them, by the names of their nodes, with the transforms above them; meshes below a camera stay."""
    half = np.sqrt(0.5)
    content = tree(
        nodes=[
            {"children": [1, 2, 3, 5], "translation": [0, 0, 9], "scale": [2, 2, 2]},
            {"camera": 0, "name": "wide", "rotation": [0, half, 0, half], "translation": [1, 0, 0]},
            {"camera": 1, "name": "plan"},
            {"camera": 2, "children": [4]},
            {"mesh": 0},
            {"camera": 3, "name": "broken"},
        ],
        cameras=[
            {"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}},
            {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 1, "zfar": 5}},
            {"type": "perspective", "name": "long", "perspective": {"yfov": 0.2, "znear": 1, "zfar": 100, "aspectRatio": 2}},
            {"type": "perspective", "perspective": {"yfov": -1, "znear": 1}},
        ],
    )
    path = tmp_path / "a.glb"
    path.write_bytes(glb(content))
    with caplog.at_level("WARNING"):
        scene = load_mesh_file(path)
    assert scene.triangles == 1 and "'broken' is unusable" in caplog.text
    wide, plan, long = scene.cameras
    assert [camera.name for camera in scene.cameras] == ["wide", "plan", "long"]
    assert wide.lens == Perspective(0.9, 0.1) and plan.lens == Orthographic(4, 1, 5) and long.lens == Perspective(0.2, 1, 100)
    np.testing.assert_allclose(wide.pose[:3, 3], [2, 0, 9])
    np.testing.assert_allclose(wide.pose[:3, :3], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-12)


def test_camera_of_a_trimesh_scene() -> None:
    scene = trimesh.Scene(trimesh.creation.box())
    scene.set_camera(angles=(0.1, 0.2, 0), distance=5)
    (camera,) = from_trimesh(scene).cameras
    np.testing.assert_allclose(camera.pose, scene.camera_transform)
    assert isinstance(camera.lens, Perspective) and camera.lens.yfov == pytest.approx(np.radians(scene.camera.fov[1]))


def test_mesh_without_camera() -> None:
    assert not from_trimesh(trimesh.creation.box()).cameras


def test_trimesh_things_only() -> None:
    with pytest.raises(SceneError, match=r"expected a trimesh\.Trimesh or trimesh\.Scene, got list"):
        from_trimesh([])  # type: ignore[arg-type]
    assert from_trimesh(trimesh.PointCloud(np.eye(3))).triangles == 3 * 4, "points are discs"


def test_double_sided(tmp_path: Path, any_renderer: Any) -> None:
    """Faces are seen from both sides, mirrored ones too, with the normal turned to the viewer."""
    from ssao_gl.scene.camera import Camera
    from ssao_gl.scene.pose import look_at

    mesh = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    mirror = trimesh.Scene()
    mirror.add_geometry(mesh, transform=np.diag([-1, 1, 1, 1.0]))
    for source in (mesh, mirror):
        for side in (4, -4):
            camera = Camera.perspective(0.8, 0.1, 20, look_at((0, 0, side), (0, 0, 0)))
            picture = any_renderer.render(from_trimesh(source), camera, (16, 12), aovs=("depth", "normal"))
            np.testing.assert_allclose(picture.depth, 4, rtol=1e-5)
            assert picture.normal[..., 2].min() > 0.99


def test_export_round_trip_of_a_scene(tmp_path: Path) -> None:
    """A scene of three meshes, two placed twice, mirrored and unevenly scaled: the same triangles come back."""
    rng = np.random.default_rng(11)
    scene = trimesh.Scene()
    meshes = {"box": trimesh.creation.box(), "ball": trimesh.creation.icosphere(1), "cone": trimesh.creation.cone(1, 2, 8)}
    for name, mesh in meshes.items():
        for k in range(1 if name == "cone" else 2):
            place = trimesh.transformations.random_rotation_matrix(rng.random(3)) @ np.diag([*rng.uniform(-2, 2, 3), 1])
            place[:3, 3] = rng.uniform(-4, 4, 3)
            scene.geometry[name] = mesh
            scene.graph.update(frame_to=f"{name}{k}", matrix=place, geometry=name)
    loaded = load_mesh_file(written(tmp_path, scene, "glb"))
    assert sorted(draw.name for draw in loaded.meshes) == ["ball", "box", "cone"]
    found = np.concatenate([corners(draw) for draw in loaded.meshes])
    np.testing.assert_allclose(sorted_rows(found), sorted_rows(scene.to_mesh().triangles), atol=3e-4)
    assert (loaded.bounds[0] <= scene.bounds[0] + 1e-5).all() and (loaded.bounds[1] >= scene.bounds[1] - 1e-5).all()


def test_open_file_objects_are_closed(tmp_path: Path) -> None:
    """Files can be removed or written at once after loading."""
    path = written(tmp_path, trimesh.creation.box(), "stl")
    handles = len(list(Path("/proc/self/fd").iterdir())) if Path("/proc/self/fd").exists() else 0
    for _ in range(5):
        load_mesh_file(path)
    if handles:
        assert len(list(Path("/proc/self/fd").iterdir())) <= handles


def test_the_camera_that_the_viewer_starts_with() -> None:
    scene = trimesh.Scene(trimesh.creation.box((2000, 1000, 500)))
    automatic = as_camera(scene)
    assert not scene.has_camera, "the scene stays as it was"
    np.testing.assert_allclose(automatic.pose, scene.camera_transform)
    view = automatic.view((400, 300))
    assert view.far == np.inf and np.isclose(1 / view.projection[1, 1], np.tan(np.radians(scene.camera.fov[1]) / 2))
    scene.set_camera(angles=(0.3, 0.2, 0.1), distance=4000, fov=(50, 40))
    np.testing.assert_allclose(as_camera(scene).pose, scene.camera_transform)
    with pytest.raises(SceneError, match="put it into"):
        as_camera(trimesh.creation.box())
