"""Broken and hostile scene files: a picture or one clear line, in bounded time and memory; nothing read beside the scene."""

from __future__ import annotations

import bz2
import gzip
import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from ssao_gl.loaders.load import load_scene

from ..command_line import refused, run
from ..scene_files import (
    ASCII_PLY,
    BIG,
    LIST,
    NAN_TRIANGLE,
    OBJ,
    PNG,
    TRIANGLE,
    XYZ,
    binary,
    changed,
    deep,
    glb,
    obj,
    ply,
    stl,
    tarred,
    tree,
    zipped,
)  # fmt: skip
from .fuzz_loaders import results

REFUSED: dict[str, tuple[str, bytes, str]] = {
    "empty": ("a.glb", b"", "the file is empty"),
    "unknown format": ("a.xyzzy", b"x", "unknown mesh format '.xyzzy'"),
    "no suffix": ("a", b"x", "unknown mesh format '.'"),
    "PNG as GLB": ("a.glb", PNG, "not a .glb file but a PNG picture"),
    "web page as OBJ": ("a.obj", b"<!DOCTYPE HTML><html>404", "but a web page"),
    "pointer as PLY": ("a.ply", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
    "GLB as PLY": ("a.ply", glb(tree()), "but a GLB file"),
    "ZIP as OBJ": ("a.obj", zipped(a__obj=OBJ.encode()), "but a ZIP archive"),
    "text as STL": ("a.stl", b"hello " * 100, "truncated or broken"),
    "text as GLB": ("a.glb", b"hello " * 100, "does not begin as a GLB file"),
    "bytes as OBJ": ("a.obj", bytes(range(256)) * 20, ""),
    "bytes as OFF": ("a.off", bytes(range(256)) * 20, ""),
    "bytes as glTF": ("a.gltf", bytes(range(256)) * 20, "JSON"),
    "GLB header only": ("a.glb", glb(tree())[:12], "truncated"),
    "GLB of version 1": ("a.glb", b"glTF\1\0\0\0" + b"\0" * 30, "only version 2"),
    "GLB in JSON": ("a.glb", glb(tree())[:100], "truncated"),
    "GLB in data": ("a.glb", glb(tree())[:-5], "truncated"),
    "GLB that claims less": ("a.glb", glb(tree(), b""), "truncated or broken"),
    "GLB without JSON": ("a.glb", glb(tree()).replace(b"JSON", b"NOPE"), "has no JSON part"),
    "GLB with bad JSON": ("a.glb", glb(b'{"asset": '), "JSON part cannot be read"),
    "GLB of a list": ("a.glb", glb(b"[1, 2]"), "not an object"),
    "JSON too deep": ("a.gltf", b"[" * 200000, "JSON part cannot be read"),
    "glTF of nothing": ("a.gltf", b"{}", ""),
    "huge buffer": ("a.glb", glb(changed("buffers.0.byteLength", BIG)), "announces 1000000000000 bytes, but 48"),
    "huge view": ("a.glb", glb(changed("bufferViews.0.byteLength", BIG)), "buffer view 0 reaches byte"),
    "negative view": ("a.glb", glb(changed("bufferViews.0.byteOffset", -4)), "buffer view 0"),
    "huge accessor": ("a.glb", glb(changed("accessors.0.count", BIG)), "accessor 0 reaches byte"),
    "negative count": ("a.glb", glb(changed("accessors.0.count", -3)), ""),
    "huge stride": ("a.glb", glb(changed("bufferViews.0.byteStride", BIG)), "accessor 0 reaches byte"),
    "accessor without data": (
        "a.glb",
        glb(changed("accessors.0", {"componentType": 5126, "count": BIG, "type": "VEC3"})),
        "no data",
    ),
    "sparse without indices": ("a.glb", glb(changed("accessors.0.sparse", {"count": 1})), "structure is broken"),
    "count as text": ("a.glb", glb(changed("accessors.0.count", "many")), "structure is broken"),
    "component type": ("a.glb", glb(changed("accessors.0.componentType", 1)), "structure is broken"),
    "text of 5000": ("a.glb", glb(changed("accessors.0.type", "x" * 5000)), " ..."),
    "name of two lines": (
        "a.glb",
        glb(changed("meshes.0.name", "a\nb\x1b[31m"), binary(NAN_TRIANGLE)),
        "mesh 'a b?[31m': 1 of 1",
    ),
    "mesh 7": ("a.glb", glb(changed("nodes.0.mesh", 7)), "structure is broken"),
    "mesh -1": ("a.glb", glb(changed("nodes.0.mesh", -1)), "structure is broken"),
    "scene 3": ("a.glb", glb(changed("scene", 3)), "structure is broken"),
    "node of text": ("a.glb", glb(changed("nodes.0", "text")), "structure is broken"),
    "primitives missing": ("a.glb", glb(changed("meshes.0", {})), "structure is broken"),
    "cycle": ("a.glb", glb(changed("nodes", [{"children": [1]}, {"children": [0], "mesh": 0}])), "must form a tree"),
    "own child": ("a.glb", glb(changed("nodes.0.children", [0])), "must form a tree"),
    "two parents": ("a.glb", glb(tree(nodes=[{"children": [1, 1]}, {"mesh": 0}])), "must form a tree"),
    "matrix of NaN": ("a.glb", glb(changed("nodes.0.matrix", [float("nan")] * 16)), "transforms must be finite"),
    "matrix too short": ("a.glb", glb(changed("nodes.0.matrix", [1, 0, 0])), "structure is broken"),
    "scale of 1e39": ("a.glb", glb(changed("nodes.0.scale", [1e39, 1, 1])), "scale it"),
    "NaN in GLB": ("a.glb", glb(tree(), binary(NAN_TRIANGLE)), "1 of 1 triangles have vertices that are not finite"),
    "index 9 in GLB": ("a.glb", glb(tree(), binary(indices=(0, 1, 9))), "names vertex 9; there are 0 to 2"),
    "index -1 in GLB": ("a.glb", glb(tree(), binary(indices=(0, 1, 2**32 - 1))), "names vertex"),
    "lines in GLB": ("a.glb", glb(changed("meshes.0.primitives.0.mode", 1)), "no triangles"),
    "no triangles in GLB": ("a.glb", glb(tree(meshes=[], nodes=[], scenes=[{}])), "no triangles"),
    "buffer outside": ("a.gltf", json.dumps(changed("buffers.0.uri", "../outside.bin")).encode(), "not in its folder"),
    "buffer at a root": ("a.gltf", json.dumps(changed("buffers.0.uri", "/etc/passwd")).encode(), "not in its folder"),
    "buffer quoted": ("a.gltf", json.dumps(changed("buffers.0.uri", "%2e%2e%2foutside.bin")).encode(), "not in its folder"),
    "buffer missing": (
        "a.gltf",
        json.dumps(changed("buffers.0.uri", "gone.bin")).encode(),
        "'gone.bin', which is not in its folder",
    ),
    "buffer remote": ("a.gltf", json.dumps(changed("buffers.0.uri", "http://127.0.0.1/a.bin")).encode(), "not in its folder"),
    "buffer of a file URL": (
        "a.gltf",
        json.dumps(changed("buffers.0.uri", "file:///etc/passwd")).encode(),
        "not in its folder",
    ),
    "buffer a device": ("a.gltf", json.dumps(changed("buffers.0.uri", "/dev/zero")).encode(), "not in its folder"),
    "data URI too short": ("a.gltf", json.dumps(changed("buffers.0.uri", "data:;base64,AAAA")).encode(), "announces 48 bytes"),
    "data URI broken": (
        "a.gltf",
        json.dumps(changed("buffers.0.uri", "data:;base64," + "!" * 80)).encode(),
        "announces 48 bytes, but 0 are there",
    ),
    "PLY header only": ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n", "no complete PLY header"),
    "PLY of 10^12 vertices": ("a.ply", ply(f"element vertex {BIG}\n{XYZ}"), "announces 1000000000000 of 'vertex'"),
    "PLY of 10^12 in text": ("a.ply", ply(f"element vertex {BIG}\n{XYZ}", form="ascii"), "announces 1000000000000"),
    "PLY of 10^12 faces": ("a.ply", ply(f"element vertex 0\n{XYZ}\nelement face {BIG}\n{LIST}"), "of 'face'"),
    "PLY of -3 vertices": ("a.ply", ply(f"element vertex -3\n{XYZ}"), "announces -3"),
    "PLY with a huge list": (
        "a.ply",
        ply(f"element vertex 3\n{XYZ}\nelement face 1\nproperty list uint int vertex_indices", binary() + b"\xff" * 4),
        "",
    ),
    "PLY torn within polygons": (
        "a.ply",
        ply(
            f"element vertex 3\n{XYZ}\nelement face 3\n{LIST}",
            binary()[:36] + b"\x03" + b"\0" * 12 + b"\x04" + b"\0" * 16 + b"\xff\0",
        ),
        "ends within face 2 of 3",
    ),
    "PLY truncated": ("a.ply", ply(f"element vertex 3\n{XYZ}\nelement face 1\n{LIST}", binary()[:-20]), "truncated"),
    "PLY in text truncated": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n", "ascii"), "truncated"),
    "PLY of another type": ("a.ply", ply("element vertex 3\nproperty quad x", b"\0" * 99), "KeyError"),
    "PLY index 9": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "ascii"), ""),
    "PLY index -1": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "ascii"), "names vertex -1"),
    "STL of 4 billion": ("a.stl", stl(TRIANGLE, 2**32 - 1), "announces 4294967295 triangles"),
    "STL truncated": ("a.stl", stl([TRIANGLE] * 9)[:-3], "truncated"),
    "STL of nothing": ("a.stl", stl([]), "no triangles"),
    "STL short": ("a.stl", b"\0" * 40, "too short"),
    "STL text truncated": ("a.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0", ""),
    "OBJ lines": ("a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "no triangles"),
    "OBJ index 9": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f 1 2 9"), ""),
    "OBJ index 0": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f 1 2 3\nf 0 1 2"), "index 0; OBJ files count from 1"),
    "OBJ index -4 of 3": (
        "a.obj",
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f -1 -2 -4"),
        "line 4: '-4' counts back past the first one",
    ),
    "OBJ index -2/0": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f -1/-0 -2 -3/0"), "index 0"),
    "OBJ index 10^12": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", f"f 1 2 {BIG}"), ""),
    "OBJ all NaN": ("a.obj", obj("v nan nan nan\nv nan 0 0\nv 0 nan 0"), ""),
    "OBJ of text": ("a.obj", obj("v a b c\nv d e f\nv g h i"), ""),
    "OBJ of many materials": (
        "a.obj",
        obj("v 0 0 0", "\n".join(f"usemtl m{i}\nf 1 1 1" for i in range(5000))),
        "5000 materials",
    ),
    "OFF truncated": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", ""),
    "OFF of 10^12": ("a.off", f"OFF\n{BIG} {BIG} 0\n0 0 0\n".encode(), ""),
    "OFF index 9": ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "outside the range"),
    "too large": ("a.obj", obj("v 0 0 0\nv 1e40 0 0\nv 0 1e40 0"), "scale it"),
    "too small": ("a.obj", obj("v 0 0 0\nv 1e-40 0 0\nv 0 1e-40 0"), "scale it"),
    "ZIP broken": ("a.zip", zipped(a__obj=OBJ.encode())[:-10], "not a readable mesh file"),
    "ZIP of nothing": ("a.zip", zipped(readme__txt=b"hello"), "holds 0 mesh files"),
    "ZIP bomb": ("a.zip", zipped(a__stl=b"\0" * (200 << 20)), "unpacks to more than 32 times"),
    "gzip bomb": ("a.tar.gz", gzip.compress(b"\0" * (200 << 20), mtime=0), "unpacks to more than 32 times"),
    "bzip2 bomb": ("a.stl.bz2", bz2.compress(b"\0" * (200 << 20), 1), "unpacks to more than 32 times"),
    "ZIP in ZIP": ("a.zip", zipped(b__zip=zipped(a__obj=OBJ.encode())), "holds 0 mesh files"),
    "ZIP with a broken mesh": ("a.zip", zipped(a__stl=b"no"), "a.stl: is too short"),
    "ZIP that leaves": (
        "a.zip",
        zipped(a__gltf=json.dumps(changed("buffers.0.uri", "../outside.bin")).encode()),
        "not in its folder",
    ),
    "tar with a bad header": ("a.tar.gz", gzip.compress(b"\xff" * 2000, mtime=0), "not a readable mesh file"),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where scenes lie, beside something that must not be read."""
    made = tmp_path / "scenes"
    made.mkdir()
    (tmp_path / "outside.bin").write_bytes(binary())
    return made


@pytest.mark.parametrize("case", REFUSED)
def test_broken_scene(case: str, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    name, content, expected = REFUSED[case]
    (folder / name).write_bytes(content)
    monkeypatch.setattr(socket, "socket", None)
    began = time.perf_counter()
    line = refused(capsys, "explain", folder / name)
    assert expected in line
    assert str(folder / name) in line
    assert time.perf_counter() - began < 10
    assert [path.name for path in folder.iterdir()] == [name]


@pytest.mark.parametrize("seed", [1, 2])
def test_fuzzed(seed: int) -> None:
    """What ``python -m tests.robustness.fuzz_loaders`` does for longer: files of every format, broken in every way."""
    found = list(results(0, 400, seed, draw=True, scenes=[]))
    assert [f for f in found if f["verdict"] == "violation"] == []
    assert len(found) == 400 and 50 < sum(f["verdict"] == "scene" for f in found) < 350


DRAWN: dict[str, tuple[str, bytes]] = {
    "points in GLB": ("a.glb", glb(changed("meshes.0.primitives.0.mode", 0))),
    "fan in GLB": ("a.glb", glb(changed("meshes.0.primitives.0.mode", 6))),
    "points in PLY": ("a.ply", ply(f"element vertex 3\n{XYZ}", binary()[:36])),
    "points in OBJ": ("a.obj", b"v 0 0 0\nv 1 0 0\n"),
    "degenerate only": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 2 0 0", "f 1 2 3")),
    "one point": ("a.glb", glb(tree(), binary(np.zeros((3, 3))))),
    "duplicate faces": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f 1 2 3\nf 1 2 3\nf 3 2 1")),
    "1e-30 units": ("a.glb", glb(tree(), binary(TRIANGLE * np.float32(1e-30)))),
    "1e30 units": ("a.glb", glb(tree(), binary(TRIANGLE * np.float32(1e29)))),
    "farther than floats can tell": ("a.stl", stl(TRIANGLE * 1e25 + np.float32(1e29))),
    "far away": ("a.obj", obj("v 1e9 0 0\nv 1000000001 0 0\nv 1e9 1 0")),
    "singular": ("a.glb", glb(changed("nodes.0.scale", [1, 0, 1]))),
    "projective": ("a.glb", glb(changed("nodes.0.matrix", [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]))),
    "unused accessor without data": (
        "a.glb",
        glb(changed("accessors", [*tree()["accessors"], {"componentType": 5126, "count": BIG, "type": "MAT4"}])),
    ),
    "unused views of the same bytes": (
        "a.glb",
        glb(
            tree(
                buffers=[{"byteLength": 1 << 20}],
                bufferViews=[*tree()["bufferViews"], *[{"buffer": 0, "byteLength": 1 << 20}] * 999],
            ),
            binary() + bytes((1 << 20) - 48),
        ),
    ),
    "deep tree": ("a.glb", glb(deep(20000))),
    "STL of many solids": ("a.stl", b"solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid a\n" * 5000),
    "archive": ("a.zip", zipped(a__obj=OBJ.encode(), b__ply=ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "ascii"))),
    "tar": ("a.tar.gz", gzip.compress(tarred("x/a.obj", OBJ.encode()), mtime=0)),
    "bzip2": ("a.obj.bz2", bz2.compress(OBJ.encode())),
    "OBJ with materials outside": ("a.obj", b"mtllib ../../../../../../etc/passwd\nusemtl a\n" + OBJ.encode()),
    "OBJ with materials at the root": ("a.obj", b"mtllib /etc/passwd\nusemtl a\n" + OBJ.encode()),
}


@pytest.mark.parametrize("case", DRAWN)
def test_strange_but_drawn(case: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name, content = DRAWN[case]
    (folder / name).write_bytes(content)
    target = folder / "out.npy"
    code, _, err = run("render", folder / name, "-o", target, "--size", "16x12", capsys=capsys)
    assert code == 0, err
    visibility = np.load(target)
    assert np.isfinite(visibility).all() and visibility.min() >= 0 and visibility.max() <= 1


def test_nothing_outside_is_read(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    """An image, and a material library, that lie outside: the scene is drawn without them, and says so."""
    from ssao_gl.loaders.resolver import in_folder

    made = tree(images=[{"uri": "../outside.png"}], textures=[{"source": 0}])
    made["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    made["meshes"][0]["primitives"][0]["material"] = 0
    (folder / "a.glb").write_bytes(glb(made))
    with caplog.at_level("WARNING"):
        load_scene(folder / "a.glb")
    assert "drawn without '../outside.png'" in caplog.text
    fetch = in_folder(folder)
    (folder / "link").symlink_to(folder.parent / "outside.bin")
    (folder / "inside.bin").write_bytes(b"x")
    assert fetch("inside.bin") is not None and fetch("sub/../inside.bin") is not None
    for name in ("../outside.bin", str(folder.parent / "outside.bin"), "link", "", ".", "a\0b", "x" * 5000):
        assert fetch(name) is None, name


@pytest.mark.parametrize("path", ["gone.glb", ".", "/dev/zero", "/dev/null/a.glb", "a\0b.glb", "n" * 300 + ".glb"])
def test_no_such_scene(path: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "expected a scene file" in refused(capsys, "explain", folder / path if path[0] != "/" else path)


def test_pipe_as_scene(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(folder / "pipe.glb")
    assert "not a regular file" in refused(capsys, "explain", folder / "pipe.glb")
    os.mkfifo(folder / "data.bin")
    (folder / "a.gltf").write_text(json.dumps(changed("buffers.0.uri", "data.bin")))
    assert "not in its folder" in refused(capsys, "explain", folder / "a.gltf")


def test_hostile_files_take_no_memory(folder: Path) -> None:
    """In a process of its own with 2 GiB of address space."""
    paths = []
    for number, (name, content, _) in enumerate(REFUSED.values()):
        paths.append(folder / f"{number}-{name}")
        paths[-1].write_bytes(content)
    script = (
        "import resource, sys, trimesh\n"
        "from ssao_gl.loaders.load import load_scene\nfrom ssao_gl.errors import SceneError\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n        load_scene(path)\n        sys.exit(path)\n"
        "    except SceneError as error:\n        assert 'MemoryError' not in str(error), error\n"
    )
    ran = subprocess.run([sys.executable, "-c", script, *map(str, paths)], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr
