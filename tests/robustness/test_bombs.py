"""Small files that would unfold to much: packed, nested, placed again and again. All are read in one process of 2 GiB."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import struct
import subprocess
import sys
import tarfile
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

from ssao_gl.errors import SceneError
from ssao_gl.loaders import resolver
from ssao_gl.loaders.load import load_scene

from ..scene_files import LIST, OBJ, XYZ, Tree, binary, changed, glb, ply, stl, tree, zipped

PRIMITIVE = {"attributes": {"POSITION": 0}, "indices": 1}


def lying(method: int, content: bytes, announced: int = 1000) -> bytes:
    """A ZIP file of a mesh that says it is smaller than it is."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        archive.writestr("a.stl", content)
    data = bytearray(out.getvalue())
    size = struct.pack("<I", announced)
    data[22:26] = size
    at = data.find(b"PK\x01\x02") + 24
    data[at : at + 4] = size
    return bytes(data)


def sparse_tar(size: int) -> bytes:
    """A tar file with a member that is one large hole, as GNU tar writes it."""
    info = tarfile.TarInfo("a.stl")
    info.type = tarfile.GNUTYPE_SPARSE
    block = bytearray(info.tobuf(tarfile.GNU_FORMAT))
    block[386 : 386 + 24] = b"%011o\0%011o\0" % (size, 0)
    block[483:495] = b"%011o\0" % size
    block[148:156] = b" " * 8
    block[148:156] = b"%06o\0 " % sum(block)
    return gzip.compress(bytes(block) + bytes(1024), mtime=0)


def picture(width: int, height: int) -> bytes:
    """A black PNG, packed as well as can be."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(bytes((3 * width + 1) * 64)) for _ in range(height // 64)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def textured(image: bytes, **material: object) -> bytes:
    """A triangle with a picture in its material."""
    parts = [binary(), np.array([[0, 0], [1, 0], [0, 1]], "<f4").tobytes(), image]
    made: Tree = tree(images=[{"bufferView": 3}], textures=[{"source": 0}], materials=[material])
    made["buffers"] = [{"byteLength": sum(map(len, parts))}]
    made["bufferViews"] += [
        {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        {"buffer": 0, "byteOffset": 72, "byteLength": len(image)},
    ]
    made["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"})
    made["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]
    return glb(made, b"".join(parts))


def placed(primitives: int, nodes: int) -> bytes:
    """A mesh of many primitives at many places."""
    meshes = [{"primitives": [PRIMITIVE] * primitives}]
    return glb(tree(meshes=meshes, nodes=[{"mesh": 0}] * nodes, scenes=[{"nodes": list(range(nodes))}]))


def overlapping() -> bytes:
    """Meshes that all show the whole of one buffer."""
    size = 1 << 20
    views = [{"buffer": 0, "byteLength": size}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": size // 12 // 3 * 3, "type": "VEC3"}]
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}}] * 1000}]
    return glb(tree(buffers=[{"byteLength": size}], bufferViews=views, accessors=accessors, meshes=meshes), bytes(size))


BIG = picture(13000, 13056)
BASE, GLOSS = {"index": 0}, "KHR_materials_pbrSpecularGlossiness"
SLOW_LISTS = "".join(f"\nproperty list uchar uchar p{i}" for i in range(20000))
CORNERS = "0 0 0\n1 0 0\n0 1 0\n"

REFUSED: dict[str, tuple[str, bytes, str]] = {
    "ZIP that lies": ("a.zip", lying(zipfile.ZIP_DEFLATED, bytes(1 << 30)), "not a readable mesh file"),
    "ZIP that lies, by bzip2": ("a.zip", lying(zipfile.ZIP_BZIP2, bytes(1 << 28)), "in a way other than 'deflate'"),
    "ZIP that lies, by LZMA": ("a.zip", lying(zipfile.ZIP_LZMA, bytes(1 << 26)), "in a way other than 'deflate'"),
    "ZIP of text": ("a.zip", zipped(a__obj=(OBJ + "f 1 2 3\n" * 3_000_000).encode()), "unpacks to more than 32 times"),
    "ZIP of many files": ("a.zip", zipped(**{f"{i}__txt": b"" for i in range(20001)}), "holds more than 20000 files"),
    "sparse tar": ("a.tar.gz", sparse_tar(1 << 36), "unpacks to more than 32 times"),
    "bzip2 in bzip2": ("a.stl.bz2", bz2.compress(bz2.compress(bytes(1 << 26))), "too short"),
    "JSON of lists": ("a.gltf", b'{"extras":[' + b"[]," * 5_000_000 + b"[]]}", "more than 4000000 values"),
    "primitives x nodes": ("a.glb", placed(1000, 1000), "draws more than"),
    "primitives": ("a.glb", placed(10_001, 1), "draws more than"),
    "overlapping meshes": ("a.glb", overlapping(), "far more than"),
    "cameras": (
        "a.glb",
        glb(tree(nodes=[{"camera": 0}] * 1001, scenes=[{"nodes": list(range(1001))}], cameras=[{}])),
        "more than 1000 cameras",
    ),
    "PLY of lists": ("a.ply", ply(f"element vertex 3\n{XYZ}\nelement face 1{SLOW_LISTS}", bytes(60000)), "20003 properties"),
    "OBJ materials with spaces": (
        "a.obj",
        ("v 0 0 0\n" + "\n".join(f"usemtl a {i}\nf 1 1 1" for i in range(5000))).encode(),
        "5000 materials",
    ),
    "OBJ materials in other words": (
        "a.obj",
        ("v 0 0 0\n" + "\n".join(f"xusemtl {i}\nf 1 1 1" for i in range(5000))).encode(),
        "5000 materials",
    ),
    "OFF of 10^18": ("a.off", b"OFF\n1000000000000000000 1 0\n0 0 0\n", "not a readable mesh file"),
}

DRAWN: dict[str, tuple[str, bytes]] = {
    "large picture": ("a.glb", textured(BIG, pbrMetallicRoughness={"baseColorTexture": BASE})),
    "large picture of gloss": (
        "a.glb",
        textured(BIG, extensions={GLOSS: {"diffuseTexture": BASE, "specularGlossinessTexture": BASE}}),
    ),
    "pictures that nobody needs": ("a.glb", textured(BIG, emissiveTexture=BASE, normalTexture=BASE)),
    "picture that starts programs": (
        "a.glb",
        textured(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n%%EndComments\n   ", pbrMetallicRoughness={"baseColorTexture": BASE}),
    ),
    "lines without end": ("a.glb", glb(tree(meshes=[{"primitives": [PRIMITIVE, *[{**PRIMITIVE, "mode": 1}] * 20_000]}]))),
    "polygon of 100 000": (
        "a.obj",
        ("".join(f"v {i % 317} {i // 317} 0\n" for i in range(100_000)) + "f " + " ".join(map(str, range(1, 100_001))) + "\nf 1 2 3\n").encode(),
    ),
    "fan of 100 000": (
        "a.obj",
        ("v 0 0 1\n" + "".join(f"v {i % 317} {i // 317} 0\n" for i in range(100_000)) + "".join(f"f 1 {i} {i + 1}\n" for i in range(2, 100_000))).encode(),
    ),
    "comment of 4 MB": ("a.off", b"#" * 4_000_000 + f"\nOFF\n3 1 0\n{CORNERS}3 0 1 2\n".encode()),
    "triangles without end": ("a.ply", ply(f"element vertex 3\n{XYZ}\nelement face 20000\n{LIST}", (CORNERS + "3 0 1 2\n4 0 1 2 0\n" * 10_000).encode(), "ascii")),
    "many objects": ("a.obj", ("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"o {i}\ng {i}\nf 1 2 3\n" for i in range(50_000))).encode()),
    "many solids": ("a.stl", b"solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid a\n" * 20_000),
    "zeros": ("a.stl", stl(np.zeros((50_000, 3, 3)))),
}  # fmt: skip

SCRIPT = """
import json, sys
from pathlib import Path
from tests.robustness.fuzz_worker import Watch, limit_memory, trial
watch = Watch()
limit_memory()
for name in sys.argv[1:]:
    print(json.dumps(trial(Path(name), watch)), flush=True)
"""


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[str, str]]:
    """What became of every file."""
    folder, paths = tmp_path_factory.mktemp("bombs").resolve(), []
    for number, (name, content, *_) in enumerate([*REFUSED.values(), *DRAWN.values()]):
        path = folder / str(number) / name
        path.parent.mkdir()
        path.write_bytes(content)
        paths.append(str(path))
    ran = subprocess.run([sys.executable, "-c", SCRIPT, *paths], capture_output=True, text=True, timeout=300)
    assert ran.returncode == 0, ran.stderr
    answers = [tuple(json.loads(line)) for line in ran.stdout.splitlines()]
    return dict(zip([*REFUSED, *DRAWN], answers, strict=True))


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case: str, verdicts: dict[str, tuple[str, str]]) -> None:
    verdict, line = verdicts[case]
    assert verdict == "refused" and REFUSED[case][2] in line, line


@pytest.mark.parametrize("case", DRAWN)
def test_drawn(case: str, verdicts: dict[str, tuple[str, str]]) -> None:
    assert verdicts[case][0] == "scene", verdicts[case]


def test_a_picture_that_is_left_out_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "a.glb").write_bytes(DRAWN["large picture"][1])
    with caplog.at_level("WARNING"):
        assert load_scene(tmp_path / "a.glb").meshes[0].vertex_colors is None
    assert "13000x13056 texels are far more than its file can mean" in caplog.text


def test_large_files_beside_a_scene(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A hole of 2 GiB named as materials, as a picture, as a buffer."""
    with (tmp_path / "film").open("wb") as file:
        file.truncate(2 << 30)
    (tmp_path / "a.obj").write_text("mtllib film\nusemtl a\n" + OBJ)
    assert load_scene(tmp_path / "a.obj").triangles == 1
    made = changed("buffers.0.uri", "film")
    (tmp_path / "a.gltf").write_text(json.dumps(made))
    with pytest.raises(SceneError, match="announces 48 bytes, but its file has 2147483648"):
        load_scene(tmp_path / "a.gltf")
    found = resolver.FolderResolver(resolver.in_folder(tmp_path))
    with pytest.raises(SceneError, match="at most 512 MiB beside a scene are read"):
        found.get("film")


def test_a_file_beside_is_read_once_and_counts_once(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"content")
    (tmp_path / "b").symlink_to("a")
    found = resolver.FolderResolver(resolver.in_folder(tmp_path))
    assert found.get("a") is found.get("./a") is found.get("b")


def test_no_part_is_lost_or_named_at_random(tmp_path: Path) -> None:
    """A mesh of many primitives: each is drawn, in the same order every time."""
    (tmp_path / "a.glb").write_bytes(placed(2000, 2))
    one, two = (load_scene(tmp_path / "a.glb") for _ in range(2))
    assert one.triangles == 4000 and [d.name for d in one.meshes] == [d.name for d in two.meshes]


def test_bombs_are_small() -> None:
    for name, (_, content, *_rest) in {**REFUSED, **DRAWN}.items():
        assert len(content) < 16 << 20, name
