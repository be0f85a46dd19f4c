"""From a scene to a file that keeps its occlusion."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.bake import Baking
from ssao_gl.bake.fans import fans
from ssao_gl.bake.gathering import trace_places
from ssao_gl.bake.settings import OcclusionTexture, Vertices
from ssao_gl.bake.source import open_source
from ssao_gl.loaders.read_options import ReadOptions
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.truth import batches, closed_forms

from ..loaders.gltf_parts import FACES, QUAD, Parts
from ..scene_files import glb, tree
from .rich_file import chunks, rich_glb

FEW = Baking(spp=16)
SMALL = OcclusionTexture(size=32)


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rich") / "rich.glb"
    path.write_bytes(rich_glb())
    return path


def box(half: float, inwards: bool = False) -> tuple[np.ndarray, np.ndarray]:
    made = trimesh.creation.box((2 * half,) * 3)
    faces = made.faces[:, ::-1] if inwards else made.faces
    return np.asarray(made.vertices, np.float32), np.asarray(faces, np.uint32)


def test_a_bowl_is_half_open_at_each_of_its_vertices() -> None:
    form = closed_forms.bowl()
    found = ao.bake(form.scene, Baking(radius=form.radius, spp=256))
    fan = found.meshes[0].visibility
    assert abs(fan.mean() - 0.5) < 0.005 and np.abs(fan - 0.5).max() < 0.06


def test_a_bowl_is_half_open_in_each_texel() -> None:
    form = closed_forms.bowl()
    angle = np.linspace(0, 1, 60)
    uv, faces = np.meshgrid(angle, angle), []
    u, v = (part.ravel() for part in uv)
    turn, rise = 2 * np.pi * u, -np.pi / 2 * v
    positions = np.stack([np.cos(turn) * np.cos(rise), np.sin(rise), np.sin(turn) * np.cos(rise)], 1).astype(np.float32)
    at = np.arange(59)
    for row in range(59):
        a, b = row * 60 + at, row * 60 + 60 + at
        faces += [np.stack([a, b, a + 1], 1), np.stack([a + 1, b, b + 1], 1)]
    bowl = Mesh(positions, np.concatenate(faces).astype(np.uint32), -positions, uv=np.stack([u, v], 1).astype(np.float32))
    found = ao.bake(Scene([bowl]), Baking(radius=form.radius, spp=256), to=OcclusionTexture(size=32, unwrap="never"))
    assert found.meshes[0].visibility.shape == (32, 32)
    assert abs(found.meshes[0].visibility.mean() - 0.5) < 0.02


def test_open_ground_is_exactly_open_and_what_lies_inside_is_black() -> None:
    inner = Mesh(*box(0.5), name="inner")
    found = ao.bake(Scene([inner, Mesh(*box(1), name="outer")]), Baking(radius=10, spp=64))
    assert [mesh.name for mesh in found.meshes] == ["inner", "outer"]
    assert (found.meshes[0].visibility == 0).all() and (found.meshes[1].visibility == 1).all()


def test_instances_share_their_mean_or_have_meshes_of_their_own(tmp_path: Path) -> None:
    far = np.eye(4)
    far[0, 3] = 50
    twice = Mesh(*box(0.5), transforms=np.stack([np.eye(4), far]), name="twice")
    scene = Scene([twice, Mesh(*box(1), name="around")])
    shared = ao.bake(scene, Baking(radius=10, spp=256, points=256))
    assert abs(shared.meshes[0].visibility.mean() - 0.5) < 0.02
    apart = ao.bake(scene, Baking(radius=10, spp=64), per_instance=True)
    assert [round(float(mesh.visibility.mean()), 3) for mesh in apart.meshes] == [0, 1, 1]
    (path,) = apart.save(tmp_path / "apart.glb")
    assert len(ao.load_scene(path).meshes) == 3


def test_a_mirror_image_keeps_its_outside_outside() -> None:
    flip = np.diag([-1.0, 1, 1, 1])
    found = ao.bake(Scene([Mesh(*box(1), transforms=flip[None])]), Baking(radius=1, spp=16))
    assert (found.meshes[0].visibility == 1).all()


def test_sides() -> None:
    """A box whose triangles all look inwards."""
    scene = Scene([Mesh(*box(1, inwards=True))])
    inside = {sides: ao.bake(scene, Baking(radius=10, spp=16, sides=sides)).meshes[0].visibility for sides in ("front", "both")}
    assert (inside["front"] == 0).all() and (inside["both"] == 1).all()


@pytest.mark.parametrize("to", [Vertices(), SMALL], ids=["vertices", "texture"])
def test_sixty_four_rays_are_near_those_of_four_thousand(to: Vertices | OcclusionTexture) -> None:
    scene = default_scene()
    few, many = (ao.bake(scene, Baking(spp=spp, sides="front"), to=to) for spp in (64, 4096))
    a, b = (np.concatenate([mesh.visibility.ravel() for mesh in found.meshes]).astype(float) for found in (few, many))
    assert abs((a - b).mean()) <= 0.003 and np.sqrt(((a - b) ** 2).mean()) <= 0.035


@pytest.mark.parametrize("to", [Vertices(), SMALL], ids=["vertices", "texture"])
def test_same_bytes_again_and_with_one_thread(to: Vertices | OcclusionTexture, rich: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    (first,) = ao.bake(rich, FEW, to=to).save(tmp_path / "first.glb")
    monkeypatch.setattr(batches, "threads", lambda: 1)
    (second,) = ao.bake(rich, FEW, to=to).save(tmp_path / "second.glb")
    assert first.read_bytes() == second.read_bytes()


def test_a_run_that_was_cut_goes_on_and_ends_in_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = closed_forms.bowl().scene
    monkeypatch.setattr(batches, "LEAST_BATCHES", 4)
    many = Baking(radius=1, spp=16, points=4)
    whole = ao.bake(scene, many)
    asked: list[int] = []

    def cut(done: int, total: int) -> None:
        asked.append(done)
        if done >= total / 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ao.bake(scene, many, cache=tmp_path, progress=cut)
    left: list[int] = []
    again = ao.bake(scene, many, cache=tmp_path, progress=lambda done, total: left.append(done))
    assert len(left) < len(asked) * 2 and left[0] > asked[0] and not again.cached
    assert (again.meshes[0].visibility == whole.meshes[0].visibility).all()
    assert ao.bake(scene, many, cache=tmp_path).cached


def test_all_else_in_a_file_is_kept(rich: Path, tmp_path: Path, errors_of: Callable[[Path], list[str]]) -> None:
    """Colours: one accessor more; the rest of the JSON part is the same, the bytes of the others begin with what they were."""
    (path,) = ao.bake(rich, FEW).save(tmp_path / "out.glb")
    before, after = chunks(rich.read_bytes()), chunks(path.read_bytes())
    assert not errors_of(path) and not errors_of(rich)
    assert after[1].startswith(before[1]) and after[2] == before[2] == b"\x08\0\0\0NOBYown data"
    made = after[0]
    colors = [mesh["primitives"][0]["attributes"].pop("COLOR_0") for mesh in made["meshes"]]
    assert colors == [len(before[0]["accessors"]), len(before[0]["accessors"]) + 1]
    del made["accessors"][colors[0] :], made["bufferViews"][len(before[0]["bufferViews"]) :]
    expected = copy.deepcopy(before[0])
    del expected["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    made["buffers"] = expected["buffers"]
    assert made == expected and list(made) == list(before[0])


def test_vertex_colours_that_are_there_are_multiplied(rich: Path) -> None:
    found = ao.bake(rich, Baking(spp=16, radius=1, sides="front"))
    stored = found.writer.document(open_source(rich, ReadOptions()).document.beside)
    from ssao_gl.loaders.gltf_accessors import raw

    number = stored.tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    visible = found.meshes[0].visibility[:, None]
    assert visible.min() < 0.9
    assert np.abs(raw(stored, number) - np.hstack([np.array([[255, 128, 0]]) * visible, 200 + 0 * visible])).max() <= 0.51


def test_textures_keep_skins_morphs_and_variants(rich: Path, tmp_path: Path, errors_of: Callable[[Path], list[str]]) -> None:
    (path,) = ao.bake(rich, FEW, to=SMALL).save(tmp_path / "out.glb")
    assert not errors_of(path)
    before, after = chunks(rich.read_bytes())[0], chunks(path.read_bytes())[0]
    for key in ("animations", "skins", "nodes", "cameras", "scenes", "extras", "extensions"):
        assert after[key] == before[key]
    floor = after["meshes"][0]["primitives"][0]
    assert set(floor["attributes"]) == set(before["meshes"][0]["primitives"][0]["attributes"]) | {"TEXCOORD_1"}
    assert floor["targets"] and floor["extras"] == {"part": "floor"}
    worn = after["materials"][floor["material"]]
    assert worn["occlusionTexture"] == {"index": 1, "texCoord": 1} and worn["extras"] == {"grain": 3}
    other = floor["extensions"]["KHR_materials_variants"]["mappings"][0]["material"]
    assert after["materials"][other]["occlusionTexture"]["index"] == 1
    assert len(trimesh.load_scene(path).geometry) == 2


@pytest.mark.parametrize("to", [Vertices(), Vertices(attribute="_AO"), SMALL], ids=["color", "attribute", "texture"])
def test_other_formats_become_glb(
    to: Vertices | OcclusionTexture, tmp_path: Path, errors_of: Callable[[Path], list[str]]
) -> None:
    source = tmp_path / "box.stl"
    trimesh.creation.box((1, 2, 3)).export(source)
    (path,) = ao.bake(source, FEW, to=to).save(tmp_path / "box.glb")
    assert not errors_of(path) and len(trimesh.load_scene(path).geometry) == 1


def test_arrays_of_meshes(rich: Path, tmp_path: Path) -> None:
    found = ao.bake(rich, FEW)
    paths = found.save(tmp_path / "arrays")
    assert [path.name for path in paths] == ["000-floor.npy", "001-wall.npy"]
    assert np.load(paths[0]).shape == (4,) and (np.load(paths[1]) == found.meshes[1].visibility).all()


def test_coordinates_that_do_not_overlap_are_used(rich: Path) -> None:
    """The embedded scene's quads would all overlap; a single quad with its own coordinates does not."""
    assert len(ao.bake(rich, FEW, to=SMALL).meshes) == 1
    form = closed_forms.plane_scene().scene.meshes[0]
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    own = ao.bake(Scene([replace(form, uv=square)]), FEW, to=OcclusionTexture(size=32, unwrap="never"))
    assert own.writer.tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] is not None
    assert own.writer.tree["materials"][0]["occlusionTexture"]["texCoord"] == 0
    with pytest.raises(ao.SceneError, match="do not overlap"):
        ao.bake(
            Scene([replace(form, uv=square * [1, 0.5]), replace(form, uv=square)]),
            FEW,
            to=OcclusionTexture(size=32, unwrap="never"),
        )


def test_vertices_that_a_texture_parts_have_one_value(tmp_path: Path) -> None:
    quads = closed_forms.wall().scene
    apart = [
        Mesh(m.positions[m.triangles.ravel()], np.arange(6, dtype=np.uint32).reshape(2, 3), name=m.name) for m in quads.meshes
    ]
    found = ao.bake(Scene(apart), FEW)
    for mesh, one in zip(apart, found.meshes, strict=True):
        _, same = np.unique(mesh.positions, axis=0, return_inverse=True)
        assert all(len(set(one.visibility[same == place])) == 1 for place in range(4))


def test_no_opengl_is_needed(tmp_path: Path, rich: Path) -> None:
    code = (
        "import sys\nfor name in ('moderngl', 'glcontext', 'OpenGL', 'pyrender'): sys.modules[name] = None\n"
        "from ssao_gl.cli import main\nmain(sys.argv[1:])"
    )
    for to in ("vertices", "texture"):
        out = tmp_path / f"{to}.glb"
        command = [sys.executable, "-c", code, "bake", str(rich), "-o", str(out), "--to", to, "--no-cache", "--size", "32"]
        command = command if to == "texture" else command[:-2]
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        assert ran.returncode == 0 and out.read_bytes().startswith(b"glTF"), ran.stderr


def test_a_file_is_there_whole_or_as_it_was(rich: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ssao_gl.bake import run

    def broken(writer: object, path: Path) -> None:
        path.write_bytes(b"glTF and no more")
        raise OSError(28, "No space left on device")

    out = tmp_path / "out.glb"
    out.write_bytes(b"old")
    found = ao.bake(rich, FEW)
    monkeypatch.setattr(run, "write_glb", broken)
    with pytest.raises(ao.FormatError, match="No space left"):
        found.save(out)
    assert out.read_bytes() == b"old" and list(tmp_path.iterdir()) == [out]


def test_places_are_traced_the_same_in_any_company() -> None:
    """Half of the rays of a double-sided place are from behind; nothing else changes."""
    scene = default_scene()
    source = open_source(scene, ReadOptions())
    settings = Baking(spp=16).with_radius(scene.default_radius())
    places, _ = fans(source.facets, source.primitives, 4, 0)
    front = trace_places(source.scene, places, replace(settings, sides="front"), None, None)
    both = trace_places(source.scene, places, replace(settings, sides="both"), None, None)
    assert both.rays == 2 * front.rays and (both.visibility >= front.visibility).all()


@pytest.mark.parametrize(
    ("broken", "says"),
    [
        ({"buffers": []}, "broken"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}]}, "nothing to bake"),
        ({"accessors": [{"bufferView": 9, "componentType": 5126, "count": 3, "type": "VEC3"}]}, "broken"),
        ({"nodes": [{"mesh": 7}]}, "broken"),
    ],
)
def test_broken_files_are_one_line(broken: dict[str, object], says: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.glb"
    path.write_bytes(glb(tree(**broken)))
    with pytest.raises(ao.SceneError, match=says) as caught:
        ao.bake(path, FEW)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)


def test_compressed_parts_stay_compressed(tmp_path: Path, errors_of: Callable[[Path], list[str]]) -> None:
    library = pytest.importorskip("DracoPy")
    parts = Parts(extensionsRequired=["KHR_draco_mesh_compression"], extensionsUsed=["KHR_draco_mesh_compression"])
    content = library.encode(QUAD, faces=FACES.reshape(-1, 3), quantization_bits=14)
    primitive = parts.quad()
    for entry in parts.tree["accessors"]:
        del entry["bufferView"]
    parts.tree["accessors"][0] |= {"min": QUAD.min(0).tolist(), "max": QUAD.max(0).tolist()}
    unique = int(library.decode(content).attributes[0]["unique_id"])
    packed = {"bufferView": parts.view(content), "attributes": {"POSITION": unique}}
    primitive["extensions"] = {"KHR_draco_mesh_compression": packed}
    path = tmp_path / "packed.glb"
    path.write_bytes(parts.show(primitive))
    (out,) = ao.bake(path, FEW).save(tmp_path / "out.glb")
    after = chunks(out.read_bytes())
    assert content in after[1] and after[0]["meshes"][0]["primitives"][0]["extensions"] == primitive["extensions"]
    assert not errors_of(out) and ao.load_scene(out).meshes[0].vertex_colors is not None
    with pytest.raises(ao.SceneError, match="Draco"):
        ao.bake(path, FEW, to=SMALL)


def test_buffers_and_pictures_of_other_files_are_packed(
    rich: Path, tmp_path: Path, errors_of: Callable[[Path], list[str]]
) -> None:
    made, binary, _ = chunks(rich.read_bytes())
    image = made["images"][0]
    view = made["bufferViews"][image.pop("bufferView")]
    (tmp_path / "wood.png").write_bytes(binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])
    image["uri"] = "wood.png"
    (tmp_path / "data.bin").write_bytes(binary)
    made["buffers"] = [
        {"byteLength": 4, "uri": "data:application/octet-stream;base64,AAAAAA=="},
        {"byteLength": len(binary), "uri": "data.bin"},
    ]
    for each in made["bufferViews"]:
        each["buffer"] = 1
    (tmp_path / "rich.gltf").write_text(json.dumps(made))
    (out,) = ao.bake(tmp_path / "rich.gltf", FEW).save(tmp_path / "out.glb")
    after = chunks(out.read_bytes())[0]
    assert not errors_of(out) and len(after["buffers"]) == 1 and "uri" not in after["images"][0] | after["buffers"][0]
    assert [len(mesh.positions) for mesh in ao.load_scene(out).meshes] == [4, 4]


def test_what_has_no_area_is_open_or_refused() -> None:
    points = np.zeros((3, 3), np.float32)
    flat = Scene([Mesh(points, np.array([[0, 1, 2]], np.uint32))])
    assert (ao.bake(flat, FEW).meshes[0].visibility == 1).all()
    with pytest.raises(ao.SceneError, match="has an area"):
        ao.bake(flat, FEW, to=SMALL)
