"""Small whole scene files of every format, for the fuzzer to break: name -> the scene's file first, then those beside it."""

from __future__ import annotations

import base64
import bz2
import gzip
import io
import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from ..loaders.gltf_parts import QUAD, UV, Parts
from ..scene_files import LIST, XYZ, Tree, binary, glb, ply, tarred, tree, zipped

Files = dict[str, bytes]


def seeds(scenes: Iterable[Path] = (), only: str = "") -> dict[str, Files]:
    """All of them, or those whose names are listed in ``only`` by commas, and whatever files of one's own are given."""
    made = {**_gltf(), **_cut(), **_moving(), **_text(), **_ply(), **_xml(), **_exported()}
    made |= {
        "zip": {"a.zip": zipped(a__obj=made["obj"]["a.obj"], b__stl=made["stl"]["a.stl"], c__glb=made["glb"]["a.glb"])},
        "tar": {"a.tar.gz": gzip.compress(tarred("a.off", made["off"]["a.off"]), mtime=0)},
        "bz2": {"a.obj.bz2": bz2.compress(made["obj"]["a.obj"])},
        "gz": {"a.ply.gz": gzip.compress(made["ply"]["a.ply"], mtime=0)},
    }
    made = {name: files for name, files in made.items() if not only or name in only.split(",")}
    for path in scenes:
        made[path.name] = {f"a{path.suffix.lower()}": path.read_bytes()}
    return made


def png(size: int = 4) -> bytes:
    """A small picture."""
    out = io.BytesIO()
    Image.fromarray(np.random.default_rng(5).integers(0, 255, (size, size, 3), np.uint8)).save(out, "PNG")
    return out.getvalue()


def _exported() -> dict[str, Files]:
    ball = trimesh.creation.icosphere(1)
    made = {}
    for suffix in ("glb", "obj", "ply", "stl", "off", "stl_ascii"):
        content = ball.export(file_type=suffix)
        name = "a.stl" if suffix == "stl_ascii" else f"a.{suffix}"
        made[suffix] = {name: content.encode() if isinstance(content, str) else content}
    return made


def _gltf() -> dict[str, Files]:
    """A textured and coloured quad under two nodes with a camera; the same as text; strips, lines and points."""
    uv = np.array([[0, 0], [1, 0], [0, 1]], "<f4").tobytes()
    normals = np.array([[0, 0, 1]] * 3, "<f4").tobytes()
    colors = np.array([[255, 0, 0, 255]] * 3, "u1").tobytes()
    picture = png()
    parts = [binary()[:36], binary()[36:], uv, normals, colors, picture]
    offsets = np.cumsum([0] + [len(part) for part in parts])
    made = tree(
        buffers=[{"byteLength": int(offsets[-1])}],
        bufferViews=[
            {"buffer": 0, "byteOffset": int(at), "byteLength": len(p)} for at, p in zip(offsets, parts, strict=False)
        ],
        accessors=[
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 4, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": True},
        ],
        images=[{"bufferView": 5, "mimeType": "image/png"}],
        samplers=[{"wrapS": 10497}],
        textures=[{"source": 0, "sampler": 0}],
        materials=[
            {
                "name": "m",
                "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}},
                "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 1], "diffuseTexture": {"index": 0}}},
            }
        ],
        meshes=[
            {
                "name": "quad",
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "NORMAL": 3}, "indices": 1, "material": 0},
                    {"attributes": {"POSITION": 0, "COLOR_0": 4}, "mode": 4},
                ],
            },
            {"primitives": [{"attributes": {"POSITION": 0}, "mode": mode} for mode in (5, 1, 0)]},
        ],
        cameras=[{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "zfar": 9}}],
        nodes=[
            {"name": "root", "children": [1, 2], "rotation": [0, 0, 0, 1]},
            {"mesh": 0, "translation": [0, 0, -2], "scale": [1, 2, 1]},
            {"camera": 0, "matrix": np.eye(4).ravel().tolist(), "children": [3]},
            {"mesh": 1},
        ],
    )  # fmt: skip
    chunk = b"".join(parts)
    embedded = {**made, "buffers": [{**made["buffers"][0], "uri": "data:;base64," + base64.b64encode(chunk).decode()}]}
    beside: Tree = {**made, "buffers": [{**made["buffers"][0], "uri": "a.bin"}], "images": [{"uri": "a.png"}]}
    return {
        "glb textured": {"a.glb": glb(made, chunk)},
        "gltf embedded": {"a.gltf": json.dumps(embedded).encode()},
        "gltf": {"a.gltf": json.dumps(beside).encode(), "a.bin": chunk, "a.png": picture},
    }


def _cut() -> dict[str, Files]:
    """Quads with alpha from a picture of odd size: cut out, and blended with colours that have alpha too."""
    made = {}
    for mode, size in (("MASK", (7, 5)), ("BLEND", (1, 3))):
        parts = Parts()
        parts.texture(np.random.default_rng(6).integers(0, 256, (*size, 4)), wrapT=33648)
        parts.tree["materials"][0] |= {"alphaMode": mode, "alphaCutoff": 0.6}
        colors = parts.accessor(np.full((4, 4), 0.9, "f4"))
        primitive = {**parts.quad(TEXCOORD_0=parts.accessor(UV), COLOR_0=colors), "material": 0}
        made[f"glb {mode.lower()}"] = {"a.glb": parts.show(primitive)}
    library = b"newmtl m\nKd 1 1 1\nd 0.7\nmap_Kd -s 2 2 -clamp on a.png\nmap_d a.png\n"
    text = b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    return made | {"obj cut": {"a.obj": text, "a.mtl": library, "a.png": png()}}


def _moving() -> dict[str, Files]:
    """A quad with a sparse accessor, a morph target, a skin, instances, a strip with a restart, points, and an animation."""
    parts = Parts(extensionsUsed=["EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_texture_transform"])
    parts.texture(np.zeros((2, 2, 3)), wrapS=33071)
    parts.tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
        "KHR_texture_transform": {"scale": [0.5, 1]}
    }
    primitive = parts.quad(
        TEXCOORD_0=parts.accessor((UV * 255).astype("u1"), True), COLOR_0=parts.accessor(np.full((4, 3), 0.5, "f4")),
        JOINTS_0=parts.accessor(np.zeros((4, 4), "u1")), WEIGHTS_0=parts.accessor(np.tile(np.array([255, 0, 0, 0], "u1"), (4, 1)), True),
    )  # fmt: skip
    which, value = parts.view(np.array([3], "u2").tobytes()), parts.view(np.array([1, 3, 0], "f4").tobytes())
    sparse = {"count": 1, "indices": {"bufferView": which, "componentType": 5123}, "values": {"bufferView": value}}
    parts.tree["accessors"][primitive["attributes"]["POSITION"]]["sparse"] = sparse
    plain = {"POSITION": parts.accessor(QUAD)}
    strip = {"attributes": plain, "indices": parts.accessor(np.array([0, 1, 2, 65535, 1, 3, 2], "u2")), "mode": 5}
    target = {"POSITION": parts.accessor(QUAD)}
    many = {"attributes": {"TRANSLATION": parts.accessor(QUAD), "ROTATION": parts.accessor(np.eye(4, dtype="f4"))}}
    inverse = parts.accessor(np.eye(4, dtype="f4").reshape(1, 16))
    times = parts.accessor(np.array([0, 1], "f4"))
    parts.tree |= {
        "skins": [{"joints": [2], "inverseBindMatrices": inverse}],
        "meshes": [
            {"primitives": [{**primitive, "material": 0, "targets": [target]}], "weights": [0.5]},
            {"primitives": [strip, {"attributes": plain, "mode": 6}, {"attributes": plain, "mode": 0}]},
        ],
        "nodes": [
            {"mesh": 0, "skin": 0, "weights": [0.25]}, {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": many}},
            {"scale": [2, 2, 2], "children": [3]}, {"mesh": 1, "extensions": {"KHR_node_visibility": {"visible": False}}},
        ],
        "scenes": [{"nodes": [0, 1, 2]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}], "samplers": [{"input": times, "output": target["POSITION"]}]}],
    }  # fmt: skip
    return {"glb moving": {"a.glb": parts.show()}}


def _text() -> dict[str, Files]:
    obj = (
        "mtllib a.mtl\no first\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 1 1 0 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
        "usemtl red\nf 1/1/1 2/2/1 3/3/1\ng two\nusemtl blue\nf 2/2/1 4/1/1 3/3/1\nf 1 2 4 3\nf -1 -2 -3\nl 1 2\n"
    )
    mtl = "newmtl red\nKd 1 0 0\nmap_Kd -s 1 1 a.png\nnewmtl blue\nKd 0 0 1\nNs 10\n"
    return {
        "obj materials": {"a.obj": obj.encode(), "a.mtl": mtl.encode(), "a.png": png()},
        "xyz": {"a.xyz": b"0 0 0\n1 0 0\n0 1 0\n"},
        "obj counting back": {
            "a.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf -3/-1 -2/-1 -1/-1 # x\nv 0 0 1\nf\t-1 -2 \\\n -4\n"
        },
        "off polygons": {"a.off": b"OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1 2 3\n3 0 1 4\n"},
    }


def _ply() -> dict[str, Files]:
    color = "property uchar red\nproperty uchar green\nproperty uchar blue"
    header = f"comment TextureFile a.png\nelement vertex 4\n{XYZ}\n{color}\nproperty float s\nproperty float t\nelement face 2\n{LIST}"
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    text = "".join(f"{x} {y} {z} 255 {x * 9} 7 {x} {y}\n" for x, y, z in corners)
    made = {"ply text": {"a.ply": ply(header, f"{text}4 0 1 3 2\n3 0 1 2\n".encode(), "ascii"), "a.png": png()}}
    for order, form in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        vertices = b"".join(
            np.array(c, f"{order}f4").tobytes() + bytes([1, 2, 3]) + np.array(c[:2], f"{order}f4").tobytes() for c in corners
        )
        faces = b"".join(b"\3" + np.array(f, f"{order}i4").tobytes() for f in ((0, 1, 2), (1, 3, 2)))
        made[f"ply {form}"] = {"a.ply": ply(header, vertices + faces, form), "a.png": png()}
        polygons = b"".join(bytes([len(f)]) + np.array(f, f"{order}i4").tobytes() for f in ((0, 1, 3, 2), (1, 3, 2)))
        made[f"ply polygons {form}"] = {"a.ply": ply(header, vertices + polygons, form), "a.png": png()}
    strips = f"element vertex 4\n{XYZ.replace('property float x', 'property uchar diffuse_red{nl}property float x')}"
    strips = strips.format(nl="\n") + "\nelement tristrips 1\nproperty list int int vertex_indices"
    rows = "".join(f"9 {x} {y} {z}\n" for x, y, z in corners) + "6 0 1 2 -1 1 3\n"
    made["ply strips"] = {"a.ply": ply(strips, rows.encode(), "ascii")}
    made["ply points"] = {"a.ply": ply(f"element vertex 4\n{XYZ}", np.array(corners, "<f4").tobytes())}
    return made


def _xml() -> dict[str, Files]:
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n<resources>'
        '<object id="1" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
        '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>\n'
        '<object id="2" type="model"><components><component objectid="1"/>'
        '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 2 0 0"/></components></object></resources>\n'
        '<build><item objectid="2"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 3 0"/></build></model>\n'
    )
    types = '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>'
    return {
        "3mf": {"a.3mf": zipped(**{"3D/3dmodel__model": model.encode(), "types__xml": types.encode()})},
        "dae": {"a.dae": DAE.encode(), "a.png": png()},
        "zae": {"a.zae": zipped(a__dae=DAE.encode(), a__png=png())},
    }


DAE = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_images><image id="i"><init_from>a.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="surf"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="samp"><sampler2D><source>surf</source></sampler2D></newparam>
<technique sid="common"><phong><diffuse><texture texture="samp" texcoord="UV"/></diffuse></phong></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="t"><float_array id="ta" count="8">0 0 1 0 1 1 0 1</float_array><technique_common>
<accessor source="#ta" count="4" stride="2"><param name="S" type="float"/><param name="T" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="m" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="1" set="0"/><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>
<triangles material="m" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="1" set="0"/><p>0 0 1 1 2 2</p></triangles>
</mesh></geometry></library_geometries>
<library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="r"><translate>0 0 1</translate><node id="c">
<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#m"/></technique_common>
</bind_material></instance_geometry></node><instance_node url="#n"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
