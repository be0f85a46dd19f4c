"""What a glTF file says is what is drawn: values after the specification, each file put together here."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssao_gl.errors import SceneError
from ssao_gl.loaders.load import load_scene
from ssao_gl.scene.material import Material
from ssao_gl.scene.model import Mesh, Scene

from ..colors import colors_at_vertices
from .gltf_parts import FACES, QUAD, UV, Parts

RED_BLUE = np.zeros((4, 4, 3), np.uint8)
RED_BLUE[:, :2], RED_BLUE[:, 2:] = (255, 0, 0), (0, 0, 255)


@pytest.fixture
def load(tmp_path: Path) -> Any:
    def loaded(content: bytes, **options: Any) -> Scene:
        (tmp_path / "a.glb").write_bytes(content)
        return load_scene(tmp_path / "a.glb", **options)

    return loaded


def one(scene: Scene) -> Mesh:
    assert len(scene.meshes) == 1
    return scene.meshes[0]


def material(mesh: Mesh) -> Material:
    assert mesh.material is not None
    return mesh.material


def size(scene: Scene) -> list[float]:
    return (scene.bounds[1] - scene.bounds[0]).round(5).tolist()


# Colours.

LINEAR = np.array([[0.2140411, 0.5, 1.0]] * 4)


@pytest.mark.parametrize("dtype", ["f4", "u1", "u2"])
@pytest.mark.parametrize("width", [3, 4])
def test_vertex_colours_are_linear_in_every_type(dtype: str, width: int, load: Any) -> None:
    rows = np.column_stack([LINEAR, np.ones(4)])[:, :width]
    stored = rows.astype("f4") if dtype == "f4" else np.round(rows * np.iinfo(dtype).max).astype(dtype)
    parts = Parts()
    colors = parts.accessor(stored, normalized=dtype != "f4")
    found = one(load(parts.show(parts.quad(COLOR_0=colors)))).vertex_colors
    assert found is not None
    np.testing.assert_allclose(found, [[128, 188, 255, 255]] * 4, atol=1)


def test_base_colour_is_a_product_of_linear_light_encoded_once(load: Any) -> None:
    parts = Parts(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1]}}])
    colors = parts.accessor(np.full((4, 4), 0.5, "f4"))
    found = colors_at_vertices(one(load(parts.show({**parts.quad(COLOR_0=colors), "material": 0}))))
    np.testing.assert_allclose(found[:, :3], [[188, 137, 99]] * 4, atol=1)
    parts = Parts()
    parts.texture(np.full((2, 2, 3), 188))
    parts.tree["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [1, 0.5, 0.25, 1]
    primitive = {**parts.quad(TEXCOORD_0=parts.accessor(UV)), "material": 0}
    found = colors_at_vertices(one(load(parts.show(primitive))))
    np.testing.assert_allclose(found[:, :3], [[188, 137, 99]] * 4, atol=1)


# Textures.


def textured(load: Any, uv: Any, normalized: bool = False, transform: Any = None, key: str = "TEXCOORD_0") -> Mesh:
    parts = Parts()
    parts.texture(RED_BLUE)
    texture = parts.tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    texture["texCoord"] = int(key[-1])
    if transform is not None:
        texture["extensions"] = {"KHR_texture_transform": transform}
    primitive = parts.quad()
    primitive["attributes"][key] = parts.accessor(uv, normalized)
    return one(load(parts.show({**primitive, "material": 0})))


def test_texture_coordinates(load: Any) -> None:
    """Row 0 of the picture is v = 0, and the colours of the quad's sides are the picture's."""
    mesh = textured(load, UV)
    assert mesh.uv is not None
    np.testing.assert_array_equal(mesh.uv, UV)
    texture = material(mesh).base_color_texture
    assert texture is not None and (texture.array == RED_BLUE).all()
    assert colors_at_vertices(mesh)[:, :3].tolist() == [[255, 0, 0], [0, 0, 255]] * 2
    np.testing.assert_array_equal(textured(load, UV, key="TEXCOORD_1").uv, UV)


def test_texture_coordinates_of_integers_are_normalized(load: Any) -> None:
    for dtype in ("u1", "u2"):
        np.testing.assert_allclose(textured(load, (UV * np.iinfo(dtype).max).astype(dtype), True).uv, UV, atol=1e-6)
    packed = np.round(UV * 4095).astype("u2")  # twelve bits of sixteen, as gltfpack has them
    found = textured(load, packed, True, {"scale": [65535 / 4095] * 2}).uv
    np.testing.assert_allclose(found, UV, atol=1e-4)


def test_texture_transform(load: Any) -> None:
    """Translation x rotation x scale; another set of coordinates may be named there."""
    found = textured(load, UV, transform={"scale": [0.5, 1], "offset": [0.5, 0]}).uv
    np.testing.assert_allclose(found, UV * [0.5, 1] + [0.5, 0], atol=1e-6)
    found = textured(load, UV, transform={"rotation": np.pi / 2, "scale": [2, 3], "offset": [5, 7]}).uv
    np.testing.assert_allclose(found, np.column_stack([5 + 3 * UV[:, 1], 7 - 2 * UV[:, 0]]), atol=1e-5)
    np.testing.assert_allclose(textured(load, UV, transform={"texCoord": 1}, key="TEXCOORD_1").uv, UV)


def test_samplers(load: Any) -> None:
    parts = Parts()
    parts.texture(RED_BLUE, wrapS=33071, wrapT=33648, magFilter=9728, minFilter=9729)
    texture = material(one(load(parts.show({**parts.quad(TEXCOORD_0=parts.accessor(UV)), "material": 0})))).base_color_texture
    assert texture is not None
    assert texture.wrap == ("clamp", "mirror") and texture.nearest and not texture.mipmaps


def test_alpha(load: Any) -> None:
    parts = Parts()
    parts.texture(np.full((2, 2, 4), 100))
    parts.tree["materials"][0] |= {"alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": True, "emissiveFactor": [1, 0, 0]}
    found = material(one(load(parts.show({**parts.quad(TEXCOORD_0=parts.accessor(UV)), "material": 0}))))
    assert (found.alpha_mode, found.alpha_cutoff, found.double_sided) == ("MASK", 0.3, True)
    assert found.emissive == (1, 0, 0)
    assert found.base_color_texture is not None and found.base_color_texture.alpha_range == (100 / 255,) * 2


# Shapes.


def test_sparse_accessor(load: Any) -> None:
    parts = Parts()
    primitive = parts.quad()
    which, value = parts.view(np.array([3], "u2").tobytes()), parts.view(np.array([1, 3, 0], "f4").tobytes())
    sparse = {"count": 1, "indices": {"bufferView": which, "componentType": 5123}, "values": {"bufferView": value}}
    parts.tree["accessors"][primitive["attributes"]["POSITION"]]["sparse"] = sparse
    scene = load(parts.show(primitive))
    assert scene.bounds.tolist() == [[-1, -1, 0], [1, 3, 0]]
    sparse["count"] = 5
    with pytest.raises(SceneError, match="replaces 5 of 4 entries"):
        load(parts.show(primitive))


def test_sparse_accessor_over_zeros(load: Any) -> None:
    parts = Parts()
    primitive = parts.quad()
    which, value = parts.view(np.array([0, 1, 2], "u1").tobytes()), parts.view(QUAD[1:].tobytes())
    entry = parts.tree["accessors"][primitive["attributes"]["POSITION"]]
    del entry["bufferView"]
    entry["sparse"] = {"count": 3, "indices": {"bufferView": which, "componentType": 5121}, "values": {"bufferView": value}}
    np.testing.assert_array_equal(one(load(parts.show(primitive), crease=0)).positions, [*QUAD[1:], [0, 0, 0]])


def armature(parts: Parts, **more: Any) -> bytes:
    box = np.array([[x, y, z] for x in (-30, 30) for y in (-20, 20) for z in (-90, 90)], "f4")
    half = float(np.sqrt(0.5))
    attributes = {
        "POSITION": parts.accessor(box),
        "JOINTS_0": parts.accessor(np.zeros((8, 4), "u1")),
        "WEIGHTS_0": parts.accessor(np.tile(np.array([1, 0, 0, 0], "f4"), (8, 1))),
    }
    primitive = {"attributes": attributes, "indices": parts.accessor(np.array([0, 1, 7, 0, 7, 2, 3, 4, 5], "u2"))}
    parts.tree["skins"] = [{"joints": [1], "inverseBindMatrices": parts.accessor(np.eye(4, dtype="f4").reshape(1, 16))}]
    parts.tree["nodes"] = [
        {"rotation": [-half, 0, 0, half], "scale": [0.01] * 3, "children": [1, *more.pop("children", [])]}, {},
        {"mesh": 0, "skin": 0, **more},
    ]  # fmt: skip
    return parts.show(primitive)


def test_skin_at_the_rest_pose(load: Any) -> None:
    """Joints place the vertices; the skinned node's own transform does not count, wherever it hangs."""
    for more in ({}, {"translation": [9, 9, 9]}, {"children": [2]}):
        parts = Parts(scenes=[{"nodes": [0] if "children" in more else [0, 2]}])
        np.testing.assert_allclose(size(load(armature(parts, **more))), [0.6, 1.8, 0.4], atol=1e-4)


def test_skin_of_a_joint_that_is_not_there(load: Any) -> None:
    parts = Parts(scenes=[{"nodes": [0, 2]}])
    content = armature(parts)
    parts.tree["skins"][0]["joints"] = []
    with pytest.raises(SceneError, match="follows joint 0; there are 0 to -1"):
        load(parts.show())
    assert content


def test_morph_weights(load: Any) -> None:
    """The mesh's, which a node's override."""
    for node, expected in (({}, 1.0), ({"weights": [0.25]}, 0.5), ({"weights": [0.0]}, 0.0)):
        parts = Parts()
        target = parts.accessor(np.tile(np.array([0, 0, 2], "f4"), (4, 1)))
        parts.tree["meshes"] = [{"primitives": [{**parts.quad(), "targets": [{"POSITION": target}]}], "weights": [0.5]}]
        assert (one(load(parts.show(**node))).positions[:, 2] == expected).all(), node


@pytest.mark.parametrize(
    ("mode", "indices", "expected"),
    [
        (5, [0, 1, 2, 3], [[0, 1, 2], [3, 2, 1]]),
        (6, [0, 1, 3, 2], [[0, 1, 3], [0, 3, 2]]),
        (5, [0, 1, 2, 65535, 1, 3, 2], [[0, 1, 2], [1, 3, 2]]),
    ],
)
def test_strips_and_fans(mode: int, indices: list[int], expected: list[list[int]], load: Any) -> None:
    parts = Parts()
    primitive = {
        "attributes": {"POSITION": parts.accessor(QUAD)},
        "indices": parts.accessor(np.array(indices, "u2")),
        "mode": mode,
    }
    assert one(load(parts.show(primitive))).triangles.tolist() == expected


def test_points_become_discs(load: Any) -> None:
    parts = Parts()
    primitive = {"attributes": {"POSITION": parts.accessor(QUAD)}, "mode": 0}
    mesh = one(load(parts.show(primitive), point_size=0.5))
    assert len(mesh.triangles) == 16
    np.testing.assert_allclose(mesh.bounds[1] - mesh.bounds[0], [2.5, 2.5, 0], atol=0.07)


# Nodes.


def test_gpu_instances_are_transforms(load: Any) -> None:
    parts = Parts()
    shifts = parts.accessor(np.array([[0, 0, 0], [3, 0, 0], [6, 0, 0]], "f4"))
    turns = parts.accessor(np.array([[0, 0, 127, 127], [0, 0, 0, 127], [0, 0, 0, 127]], "i1"), normalized=True)
    many = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": shifts, "ROTATION": turns}}}
    mesh = one(load(parts.show(parts.quad(), extensions=many)))
    assert mesh.transforms.shape == (3, 4, 4) and len(mesh.triangles) == 2
    np.testing.assert_allclose(mesh.bounds, [[-1, -1, 0], [7, 1, 0]], atol=1e-6)
    np.testing.assert_allclose(mesh.transforms[0, :3, 0], [0, 1, 0], atol=1e-6)


def test_hidden_nodes_and_all_below_are_left_out(load: Any) -> None:
    hidden = {"KHR_node_visibility": {"visible": False}}
    parts = Parts(nodes=[{"mesh": 0}, {"extensions": hidden, "children": [2]}, {"mesh": 0}], scenes=[{"nodes": [0, 1]}])
    assert load(parts.show(parts.quad())).triangles == 2


def animated(interpolation: str, output: Any, path: str = "translation") -> bytes:
    parts = Parts()
    times = parts.accessor(np.array([1, 3], "f4"))
    channel = {"sampler": 0, "target": {"node": 0, "path": path}}
    sampler = {"input": times, "output": parts.accessor(np.array(output, "f4")), "interpolation": interpolation}
    parts.tree["animations"] = [{"name": "walk", "channels": [channel], "samplers": [sampler]}]
    return parts.show(parts.quad())


ZERO = [0, 0, 0]


@pytest.mark.parametrize(
    ("kind", "output", "time", "expected"),
    [
        ("LINEAR", [[0, 0, 0], [4, 0, 0]], 1.5, 1.0),
        ("LINEAR", [[0, 0, 0], [4, 0, 0]], 99.0, 4.0),
        ("STEP", [[0, 0, 0], [4, 0, 0]], 2.9, 0.0),
        ("STEP", [[0, 0, 0], [4, 0, 0]], 3.0, 4.0),
        ("CUBICSPLINE", [ZERO, ZERO, ZERO, ZERO, [4, 0, 0], ZERO], 2.0, 2.0),
        ("CUBICSPLINE", [ZERO, ZERO, [1, 0, 0], ZERO, ZERO, ZERO], 2.0, 0.25),
    ],
)
def test_animation(kind: str, output: Any, time: float, expected: float, load: Any) -> None:
    content = animated(kind, output)
    assert one(load(content, animation="walk", time=time)).transforms[0, 0, 3] == pytest.approx(expected)
    assert one(load(content)).transforms[0, 0, 3] == 0, "the rest pose"


def test_animation_turns_the_short_way(load: Any) -> None:
    content = animated("LINEAR", [[0, 0, 0, 1], [0, 0, -1, 0]], "rotation")  # half a turn
    found = one(load(content, animation="0", time=2.0)).transforms[0]
    np.testing.assert_allclose(np.abs(found[:2, 0]), [0, 1], atol=1e-6)


def test_animation_that_is_not_there(load: Any) -> None:
    content = animated("STEP", [ZERO, ZERO])
    with pytest.raises(SceneError, match=r"has no animation 'wolk'; there are 'walk'\. Did you mean 'walk'\?"):
        load(content, animation="wolk")
    with pytest.raises(SceneError, match="finite number of seconds"):
        load(content, animation="walk", time=float("nan"))
    parts = Parts()
    with pytest.raises(SceneError, match="has no animations"):
        load(parts.show(parts.quad()), animation="walk")


# Extensions.


def test_extensions_that_are_not_read(load: Any, caplog: pytest.LogCaptureFixture) -> None:
    """Needed ones are refused; those that change the picture are named once; light and physics need no word."""
    parts = Parts(extensionsUsed=["XX_hologram", "KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_texture_basisu"])
    content = parts.show(parts.quad())
    with caplog.at_level("WARNING"):
        scene = load(content)
    assert scene.warnings == ("uses glTF extensions that are not read: XX_hologram, KHR_texture_basisu",)
    assert caplog.text.count("not read") == 1
    parts.tree["extensionsRequired"] = ["XX_hologram"]
    with pytest.raises(SceneError, match="needs the glTF extension XX_hologram, which cannot be read"):
        load(parts.show())


@pytest.mark.parametrize(
    ("name", "module", "cure"),
    [
        ("KHR_draco_mesh_compression", "DracoPy", r"ssao_gl\[draco\]"),
        ("EXT_meshopt_compression", "meshoptimizer", r"ssao_gl\[meshopt\]"),
    ],
)
def test_compression_names_its_cure(name: str, module: str, cure: str, load: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    parts = Parts(extensionsRequired=[name])
    with pytest.raises(SceneError, match=cure):
        load(parts.show(parts.quad()))


def test_meshopt(load: Any) -> None:
    """Positions and indices of a ball come back bit by bit."""
    library = pytest.importorskip("meshoptimizer")
    import trimesh

    ball = trimesh.creation.icosphere(2)
    positions, indices = ball.vertices.astype("f4"), ball.faces.astype("u4").ravel()
    parts = Parts(extensionsRequired=["EXT_meshopt_compression"], extensionsUsed=["EXT_meshopt_compression"])
    primitive = {"attributes": {"POSITION": parts.accessor(positions)}, "indices": parts.accessor(indices)}
    packed = [
        (library.encode_vertex_buffer(positions, len(positions), 12), len(positions), 12, "ATTRIBUTES"),
        (library.encode_index_buffer(indices, len(indices), len(positions)), len(indices), 4, "TRIANGLES"),
    ]
    for number, (content, count, stride, mode) in enumerate(packed):
        where = parts.tree["bufferViews"][parts.view(bytes(content))]
        entry = {"buffer": 0, "byteOffset": where["byteOffset"], "byteLength": where["byteLength"]}
        entry |= {"count": count, "byteStride": stride, "mode": mode}
        parts.tree["bufferViews"][number]["extensions"] = {"EXT_meshopt_compression": entry}
    mesh = one(load(parts.show(primitive), crease=0))
    np.testing.assert_array_equal(mesh.positions, positions)
    np.testing.assert_array_equal(np.sort(mesh.triangles, 1), np.sort(ball.faces, 1))


def test_draco(load: Any) -> None:
    library = pytest.importorskip("DracoPy")
    parts = Parts(extensionsRequired=["KHR_draco_mesh_compression"])
    content = library.encode(QUAD, faces=FACES.reshape(-1, 3), quantization_bits=14)
    attribute = int(library.decode(content).attributes[0]["unique_id"])
    primitive = parts.quad()
    for entry in parts.tree["accessors"]:
        del entry["bufferView"]
    packed = {"bufferView": parts.view(content), "attributes": {"POSITION": attribute}}
    primitive["extensions"] = {"KHR_draco_mesh_compression": packed}
    scene = load(parts.show(primitive))
    assert scene.triangles == 2
    np.testing.assert_allclose(scene.bounds, [[-1, -1, 0], [1, 1, 0]], atol=1e-3)
    parts.tree["bufferViews"][packed["bufferView"]]["byteLength"] = 20
    with pytest.raises(SceneError, match="cannot be unpacked"):
        load(parts.show())
