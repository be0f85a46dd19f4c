"""Broken and hostile files and arguments: one clear line, exit code 2, nothing written, nothing read beside the scene."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import tarfile
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssao_gl.cli import main
from ssao_gl.errors import SceneError
from ssao_gl.scene import Scene

Tree = dict[str, Any]
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
BIG = 10**12


def tree(**changes: Any) -> Tree:
    """A glTF of one triangle."""
    made: Tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 48}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    return made | changes


def binary(positions: Any = TRIANGLE, indices: Any = (0, 1, 2)) -> bytes:
    return np.asarray(positions, "<f4").tobytes() + np.asarray(indices, "<u4").tobytes()


def glb(content: Tree | bytes, chunk: bytes | None = None) -> bytes:
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunk = binary() if chunk is None else chunk
    size = 20 + len(text) + 8 + len(chunk)
    head = struct.pack("<4sIII4s", b"glTF", 2, size, len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(chunk), b"BIN\0") + chunk


def changed(path: str, value: Any) -> Tree:
    """The triangle with one thing set: ``"accessors.0.count"``."""
    made = json.loads(json.dumps(tree()))
    *parents, last = [int(part) if part.isdigit() else part for part in path.split(".")]
    at = made
    for part in parents:
        at = at[part]
    at[last] = value
    return made


def deep(count: int) -> Tree:
    nodes = [{"children": [i + 1], "translation": [0, 0, 1e-3]} for i in range(count - 1)] + [{"mesh": 0}]
    return tree(nodes=nodes)


def ply(header: str, body: bytes = b"", form: str = "binary_little_endian") -> bytes:
    return f"ply\nformat {form} 1.0\n{header}\nend_header\n".encode() + body


XYZ = "property float x\nproperty float y\nproperty float z"
LIST = "property list uchar int vertex_indices"
ASCII_PLY = f"element vertex 3\n{XYZ}\nelement face 1\n{LIST}"


def stl(triangles: Any, count: int | None = None) -> bytes:
    corners = np.asarray(triangles, "<f4").reshape(-1, 9)
    body = b"".join(b"\0" * 12 + row.tobytes() + b"\0\0" for row in corners)
    return b"\0" * 80 + struct.pack("<I", len(corners) if count is None else count) + body


def zipped(**files: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name.replace("__", "."), content)
    return out.getvalue()


def tarred(name: str, content: bytes) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as archive:
        info = tarfile.TarInfo(name)
        info.size = len(content)
        archive.addfile(info, io.BytesIO(content))
    return out.getvalue()


def obj(vertices: str, faces: str = "f 1 2 3") -> bytes:
    return f"{vertices}\n{faces}\n".encode()


PNG = b"\x89PNG\r\n\x1a\n" + b"\0" * 100
NAN_TRIANGLE = TRIANGLE * np.array([[1], [np.nan], [1]], "<f4")
MATRIX = np.eye(4)

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
    "unused accessor without data": (
        "a.glb",
        glb(changed("accessors", [*tree()["accessors"], {"componentType": 5126, "count": BIG, "type": "MAT4"}])),
        "far more than",
    ),
    "views of the same bytes": (
        "a.glb",
        glb(
            tree(
                buffers=[{"byteLength": 1 << 20}],
                bufferViews=[*tree()["bufferViews"], *[{"buffer": 0, "byteLength": 1 << 20}] * 999],
            ),
            binary() + bytes((1 << 20) - 48),
        ),
        "far more than",
    ),
    "sparse positions": ("a.glb", glb(changed("accessors.0.sparse", {"count": 1})), "is sparse"),
    "count as text": ("a.glb", glb(changed("accessors.0.count", "many")), "structure is broken"),
    "component type": ("a.glb", glb(changed("accessors.0.componentType", 1)), "structure is broken"),
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
    "Draco": ("a.glb", glb(tree(extensionsRequired=["KHR_draco_mesh_compression"])), "Draco"),
    "meshopt": ("a.glb", glb(tree(extensionsRequired=["EXT_meshopt_compression"])), "EXT_meshopt_compression"),
    "NaN in GLB": ("a.glb", glb(tree(), binary(NAN_TRIANGLE)), "1 of 1 triangles have vertices that are not finite"),
    "index 9 in GLB": ("a.glb", glb(tree(), binary(indices=(0, 1, 9))), "names vertex 9; there are 0 to 2"),
    "index -1 in GLB": ("a.glb", glb(tree(), binary(indices=(0, 1, 2**32 - 1))), "names vertex"),
    "lines in GLB": ("a.glb", glb(changed("meshes.0.primitives.0.mode", 1)), "no triangles"),
    "points in GLB": ("a.glb", glb(changed("meshes.0.primitives.0.mode", 0)), "no triangles"),
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
        "not a readable mesh file",
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
    "PLY truncated": ("a.ply", ply(f"element vertex 3\n{XYZ}\nelement face 1\n{LIST}", binary()[:-20]), "truncated"),
    "PLY in text truncated": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n", "ascii"), "truncated"),
    "PLY of another type": ("a.ply", ply("element vertex 3\nproperty quad x", b"\0" * 99), "KeyError"),
    "PLY index 9": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "ascii"), ""),
    "PLY index -1": ("a.ply", ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "ascii"), "names vertex -1"),
    "PLY points": ("a.ply", ply(f"element vertex 3\n{XYZ}", binary()[:36]), "no triangles, only PointCloud"),
    "STL of 4 billion": ("a.stl", stl(TRIANGLE, 2**32 - 1), "announces 4294967295 triangles"),
    "STL truncated": ("a.stl", stl([TRIANGLE] * 9)[:-3], "truncated"),
    "STL of nothing": ("a.stl", stl([]), "no triangles"),
    "STL short": ("a.stl", b"\0" * 40, "too short"),
    "STL text truncated": ("a.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0", ""),
    "OBJ points": ("a.obj", b"v 0 0 0\nv 1 0 0\n", "no triangles, only PointCloud"),
    "OBJ lines": ("a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "no triangles"),
    "OBJ index 9": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f 1 2 9"), ""),
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
    "ZIP bomb": ("a.zip", zipped(a__stl=b"\0" * (200 << 20)), "unpacks to more than 50 times"),
    "gzip bomb": ("a.tar.gz", gzip.compress(b"\0" * (200 << 20)), "unpacks to more than 50 times"),
    "bzip2 bomb": ("a.stl.bz2", bz2.compress(b"\0" * (200 << 20), 1), "unpacks to more than 50 times"),
    "ZIP in ZIP": ("a.zip", zipped(b__zip=zipped(a__obj=OBJ.encode())), "holds 0 mesh files"),
    "ZIP with a broken mesh": ("a.zip", zipped(a__stl=b"no"), "a.stl: is too short"),
    "ZIP that leaves": (
        "a.zip",
        zipped(a__gltf=json.dumps(changed("buffers.0.uri", "../outside.bin")).encode()),
        "not in its folder",
    ),
    "tar with a bad header": ("a.tar.gz", gzip.compress(b"\xff" * 2000), "not a readable mesh file"),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where scenes lie, beside something that must not be read."""
    made = tmp_path / "scenes"
    made.mkdir()
    (tmp_path / "outside.bin").write_bytes(binary())
    return made


def run(*arguments: object, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the command line, in this process."""
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    code = ended.value.code
    return (code if isinstance(code, int) else 0), out, err


def refused(capsys: pytest.CaptureFixture[str], *arguments: object, code: int = 2) -> str:
    """The one line of a command that must fail."""
    found, out, err = run(*arguments, capsys=capsys)
    assert found == code, (found, out, err)
    assert err.startswith("ssao-gl: ") and err.count("\n") == 1, err
    assert "unforeseen" not in err and "Traceback" not in err, err
    assert len(err) < 800
    return err


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


@pytest.mark.parametrize("suffix", ["glb", "gltf", "obj", "ply", "stl", "off", "zip"])
def test_truncated_anywhere(suffix: str, folder: Path) -> None:
    """Cut at any place: a scene (text may still be whole) or SceneError."""
    import trimesh

    mesh = trimesh.creation.icosphere(1)
    if suffix == "gltf":
        files = trimesh.Scene(mesh).export(file_type="gltf")
        content = files.pop("model.gltf")
        for name, data in files.items():
            (folder / name).write_bytes(data)
    elif suffix == "zip":
        content = zipped(a__obj=mesh.export(file_type="obj").encode())
    else:
        content = mesh.export(file_type=suffix)
    content = content.encode() if isinstance(content, str) else content
    for share in np.linspace(0.01, 0.99, 12):
        path = folder / f"cut.{suffix}"
        path.write_bytes(content[: int(len(content) * share)])
        try:
            Scene.load(path)
        except SceneError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)


@pytest.mark.parametrize("suffix", ["glb", "obj", "ply", "stl", "off"])
def test_flipped_bits(suffix: str, folder: Path) -> None:
    """A scene or SceneError, and never for long."""
    import trimesh

    mesh = trimesh.creation.icosphere(1)
    whole = mesh.export(file_type=suffix)
    whole = whole.encode() if isinstance(whole, str) else whole
    rng = np.random.default_rng(7)
    path = folder / f"flip.{suffix}"
    for _ in range(25):
        data = bytearray(whole)
        for at in rng.integers(0, min(len(data), 400), 3):
            data[at] ^= 1 << rng.integers(0, 8)
        path.write_bytes(data)
        began = time.perf_counter()
        try:
            Scene.load(path)
        except SceneError as error:
            assert "\n" not in str(error)
        assert time.perf_counter() - began < 10


DRAWN: dict[str, tuple[str, bytes]] = {
    "degenerate only": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 2 0 0", "f 1 2 3")),
    "one point": ("a.glb", glb(tree(), binary(np.zeros((3, 3))))),
    "duplicate faces": ("a.obj", obj("v 0 0 0\nv 1 0 0\nv 0 1 0", "f 1 2 3\nf 1 2 3\nf 3 2 1")),
    "1e-30 units": ("a.glb", glb(tree(), binary(TRIANGLE * np.float32(1e-30)))),
    "1e30 units": ("a.glb", glb(tree(), binary(TRIANGLE * np.float32(1e29)))),
    "far away": ("a.obj", obj("v 1e9 0 0\nv 1000000001 0 0\nv 1e9 1 0")),
    "singular": ("a.glb", glb(changed("nodes.0.scale", [1, 0, 1]))),
    "projective": ("a.glb", glb(changed("nodes.0.matrix", [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]))),
    "deep tree": ("a.glb", glb(deep(20000))),
    "STL of many solids": ("a.stl", b"solid a\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid a\n" * 5000),
    "archive": ("a.zip", zipped(a__obj=OBJ.encode(), b__ply=ply(ASCII_PLY, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "ascii"))),
    "tar": ("a.tar.gz", gzip.compress(tarred("x/a.obj", OBJ.encode()))),
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
    from ssao_gl.adapters import mesh_files

    made = changed("images", [{"uri": "../outside.png"}])
    (folder / "a.glb").write_bytes(glb(made))
    with caplog.at_level("WARNING"):
        Scene.load(folder / "a.glb")
    assert "drawn without '../outside.png'" in caplog.text
    fetch = mesh_files._in_folder(folder)
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
        "from ssao_gl.scene import Scene\nfrom ssao_gl.errors import SceneError\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n        Scene.load(path)\n        sys.exit(path)\n"
        "    except SceneError as error:\n        assert 'MemoryError' not in str(error), error\n"
    )
    ran = subprocess.run([sys.executable, "-c", script, *map(str, paths)], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr


CAMERA: Tree = {"name": "front", "eye": [0, 0, 5], "target": [0, 0, 0], "yfov_deg": 40}


def camera_file(**changes: Any) -> str:
    entry = {key: value for key, value in (CAMERA | changes).items() if value is not ...}
    return json.dumps({"cameras": [entry]})


CAMERAS: dict[str, tuple[str, str]] = {
    "empty": ("", "the file is empty"),
    "not JSON": ("{", "not JSON"),
    "a list": ("[]", "expected an object with a list 'cameras'"),
    "no cameras": ('{"cameras": []}', "expected an object with a list 'cameras'"),
    "cameras of text": ('{"cameras": "front"}', "expected an object with a list 'cameras'"),
    "a camera of text": ('{"cameras": ["front"]}', "camera 0 is not an object"),
    "too deep": ("[" * 100000, "not JSON"),
    "eye missing": (camera_file(eye=...), "lacks 'eye'"),
    "eye misspelt": (camera_file(eye=..., eyes=[0, 0, 1]), "lacks 'eye'. Did you mean 'eyes'?"),
    "eye of text": (camera_file(eye="here"), "('front')"),
    "eye of two": (camera_file(eye=[0, 1]), "three finite numbers"),
    "eye of NaN": (camera_file(eye=[0, 0, float("nan")]), "three finite numbers"),
    "eye of an object": (camera_file(eye={"x": 1}), "camera 0"),
    "eye is target": (camera_file(eye=[0, 0, 0]), "same point"),
    "up parallel": (camera_file(up=[0, 0, 1]), "parallel"),
    "up zero": (camera_file(up=[0, 0, 0]), "parallel"),
    "yfov missing": (camera_file(yfov_deg=...), "lacks 'yfov_deg'"),
    "yfov 0": (camera_file(yfov_deg=0), "yfov"),
    "yfov 180": (camera_file(yfov_deg=180), "yfov"),
    "yfov NaN": (camera_file(yfov_deg=float("nan")), "yfov"),
    "yfov of text": (camera_file(yfov_deg="wide"), "'wide'"),
    "yfov huge": (camera_file(yfov_deg=10**400), "camera 0"),
    "znear 0": (camera_file(znear=0), "znear=0 must be above 0"),
    "znear -1": (camera_file(znear=-1), "znear=-1 must be above 0"),
    "zfar before znear": (camera_file(znear=2, zfar=1), "zfar=1 must lie behind znear=2"),
    "zfar NaN": (camera_file(zfar=float("nan")), "zfar"),
    "ortho 0": (camera_file(ortho_height=0), "orthographic height"),
    "radius 0": (camera_file(ao_radius=0), "ao_radius=0"),
    "radius NaN": (camera_file(ao_radius=float("nan")), "ao_radius"),
    "radius infinite": (camera_file(ao_radius=float("inf")), "ao_radius"),
    "radius of a list": (camera_file(ao_radius=[1]), "camera 0"),
}


@pytest.mark.parametrize("case", CAMERAS)
def test_broken_camera_file(case: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, expected = CAMERAS[case]
    path = folder / "a.cam.json"
    path.write_text(text)
    line = refused(capsys, "explain", "--camera", path)
    assert str(path) in line and expected in line


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("a.cam.json:frnt", "Did you mean 'front'?"),
        ("a.cam.json:7", "a number from 0 to 0"),
        ("a.cam.json:-1", "no camera '-1'"),
        ("a.cam.json:²", "no camera '²'"),
        ("gone.cam.json", "no such file"),
        ("gone.cam.json:front", "no such file"),
        (".", "is a folder"),
        ("/dev/zero", "not a regular file"),
    ],
)
def test_wrong_camera(spec: str, expected: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.cam.json").write_text(camera_file())
    assert expected in refused(capsys, "explain", "--camera", spec if spec[0] == "/" else f"{folder}/{spec}")


ARGUMENTS: dict[str, str] = {
    "rendr": "Did you mean 'render'?",
    "render --size 0x0": "sides from 1",
    "render --size 99999x99999": "sides from 1 to 65536",
    "render --size -5x3": "WIDTHxHEIGHT",
    "render --size 10": "WIDTHxHEIGHT",
    "render --size 1e3x5": "WIDTHxHEIGHT",
    "render --size ٣x٣": "WIDTHxHEIGHT",
    "render --size 4x": "WIDTHxHEIGHT",
    "render --size 123456789012345678901234567890x5": "sides from 1",
    "render --bogus": "Unknown option",
    "render --siz 4x4": "Did you mean --size?",
    "render --samples": "requires an argument",
    "render --samples many": "unable to convert",
    "render --samples 0": "alchemy.samples=0: must be 1 to",
    "render --samples -4": "alchemy.samples=-4: must be 1 to",
    f"render --samples {10**400}": "must be a finite whole number",
    "render --radius nan": "alchemy.radius=nan: must be a finite number",
    "render --radius inf": "must be a finite number",
    "render --radius -1": "must be above 0 (scene units)",
    "render --radius wide": "unable to convert",
    "render --method alchmy": "Did you mean 'alchemy'?",
    "render --blur joit": "Did you mean 'joint'?",
    "render --set foo": "must be key=value",
    "render --set foo=1": "alchemy has no setting 'foo'",
    "render --set radus=1": "Did you mean 'radius'?",
    "render --set lecture.radius=1": "add --method lecture",
    "render --set joint.radius=1": "unknown group of settings 'joint'",
    "render --set blur.radius=99": "must be 1 to 16 (pixels)",
    "render --set samples=2.5": "must be a whole number",
    "render --set shading.background=red": "must look like #rrggbb",
    "render --blur none --set blur.radius=1": "blur is 'none'",
    "render --aov visiblity": "Did you mean 'visibility'?",
    "render --aov ,": "name at least one",
    "render --aov depth,normal -o a.png": "one file holds one AOV",
    "render --bits 12": "must be 8 or 16",
    "render --gl egl": "unknown provider",
    "render --turntable -1": "must be 1 to",
    "render --turntable 3 -o a.png": "a turntable goes to a folder",
    "render --turntable 3 -o tt --json a.json": "leave it out",
    "render --eye 1,2": "must be three numbers",
    "render --eye 1,2,3,4": "must be three numbers",
    "render --eye 1,nan,3": "three finite numbers",
    "render --eye=": "must be three numbers",
    "render --eye 1,1,1 --target 1,1,1": "same point",
    "render --eye 0,5,0 --target 0,0,0 --up 0,1,0": "parallel",
    "render --yfov-deg 0": "between 0 and 180",
    "render --yfov-deg 180": "between 0 and 180",
    "render --yfov-deg nan": "between 0 and 180",
    "render --znear 0": "znear=0 must be above 0",
    "render --znear 5 --zfar 1": "must lie behind",
    "render --zfar nan": "must lie behind",
    "render --ortho 0": "orthographic height",
    "render --ortho nan": "orthographic height",
    "render --ortho 3 --yfov-deg 3": "exclude each other",
    "render --config gone.toml": "no such file",
    "render --config /dev/zero": "not a regular file",
    "render -o a.jpg": "unknown suffix '.jpg'",
    "render -o a.pngg": "Did you mean '.png'?",
    "render -o gone/a.png": "no folder gone",
    "render -o here.txt/x/": "here.txt is not a folder",
    "render -o here.txt/a.png": "here.txt is not a folder",
    "render -o file": "is a file",
    "render -o /proc/a.png": "cannot write /proc/a.png",
    "render -o /proc/a/": "cannot write /proc/a",
    "render --json gone/a.json": "no folder gone",
    "render --json --size 4x4": "must be a file name",
    "explain --aov foo": "unknown AOV",
    "explain --crease-deg 200 here.obj": "must be 0 to 180",
    "explain --up-axis w here.obj": "must be x, y, z or auto",
    "methods alchem": "Did you mean 'alchemy'?",
    "shader alchem": "there is no shader 'alchem'",
    "shader ../../pyproject.toml": "there is no shader",
    "shader alchemy --dialect es30": "Did you mean 'es300'?",
    "shader alchemy --define 3=4": "must be NAME or NAME=VALUE",
    "compare gone.png gone.png": "no such file",
    "compare small.npy large.npy": "shape",
    "compare small.npy small.npy --metric rmsee": "Did you mean 'rmse'?",
    "compare small.npy small.npy --max-abs nan": "must be at least 0",
    "compare small.npy small.npy --max-abs -1": "must be at least 0",
    "compare small.npy small.npy --diff a.jpg": "unknown suffix '.jpg'",
    "compare small.npy here.txt": "not a readable picture",
    "apply --depth small.npy": "say how the depth was seen",
    "apply --depth small.npy --yfov-deg 40 --ortho 2": "say how the depth was seen",
    "apply --depth small.npy --intrinsics 1,2,3": "fx,fy,cx,cy",
    "apply --depth small.npy --intrinsics 1,0,3,4": "above 0",
    "apply --depth small.npy --yfov-deg 40 --strength 2": "must be 0 to 1",
    "apply --depth small.npy --yfov-deg 40 -o a.jpg": "unknown suffix",
    "apply --yfov-deg 40": "--depth",
    "apply --depth gone.npy --yfov-deg 40": "no such file",
    "apply --depth objects.npy --yfov-deg 40": "not a readable picture or array",
    "apply --depth complex.npy --yfov-deg 40": "holds complex128",
    "apply --depth text.npy --yfov-deg 40": "expected numbers",
    "apply --depth none.npy --yfov-deg 40": "",
    "apply --depth flat.npy --yfov-deg 40": "shape (12,)",
    "apply --depth huge.npy --yfov-deg 40": "not a readable picture or array",
    "apply --depth pack.npy --yfov-deg 40": "NPZ",
    "apply --depth small.png --yfov-deg 40": "depth must be floats",
}


@pytest.fixture
def place(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with some files in it; nothing may be added or changed."""
    from PIL import Image

    monkeypatch.chdir(folder)
    np.save("small.npy", np.ones((3, 4), np.float32))
    np.save("large.npy", np.ones((5, 4), np.float32))
    np.save("objects.npy", np.array([[{}]], object), allow_pickle=True)
    np.save("complex.npy", np.ones((3, 4), complex))
    np.save("text.npy", np.array([["a", "b"]]))
    np.save("none.npy", np.ones((0, 4), np.float32))
    np.save("flat.npy", np.ones(12, np.float32))
    with Path("huge.npy").open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (BIG, 4)})
    with Path("pack.npy").open("wb") as file:
        np.savez(file, a=np.ones(3))
    Image.fromarray(np.zeros((3, 4), np.uint8)).save("small.png")
    Path("here.txt").write_text("hello")
    Path("file").write_text("hello")
    Path("here.obj").write_text(OBJ)
    before = sorted(folder.rglob("*"))
    yield folder
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("line", ARGUMENTS, ids=lambda line: line[:60])
def test_bad_arguments(line: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ARGUMENTS[line] in refused(capsys, *line.split())


TOML: dict[str, str] = {
    "radius = ": "not TOML",
    "a" + "[" * 5000: "not TOML",
    "radius = 1": "groups are tables, like [alchemy]",
    "method = 3": "must be a name in quotes",
    "method = 'alchmy'": "Did you mean 'alchemy'?",
    "[alchmy]\nradius = 1": "Did you mean 'alchemy'?",
    "[alchemy]\nradus = 1": "Did you mean 'radius'?",
    "[alchemy]\nradius = 'a'": "must be a number",
    "[alchemy]\nradius = true": "must be a finite number",
    "[alchemy]\nradius = []": "must be a finite number",
    "[alchemy]\nradius = nan": "must be a finite number",
    "[alchemy]\nradius = 1979-05-27": "must be a finite number",
    "[alchemy.radius]\nx = 1": "must be a finite number",
    "[alchemy]\nsamples = 1.5": "must be a finite whole number",
    "[shading]\nbackground = 7": "must be text",
    "blur = 'none'\n[blur_joint]\nradius = 99": "",
}


@pytest.mark.parametrize("text", TOML)
def test_bad_settings_file(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "a.toml"
    path.write_text(text)
    if TOML[text]:
        assert TOML[text] in refused(capsys, "explain", "--config", path)
    else:
        assert run("explain", "--config", path, capsys=capsys)[0] == 0


def test_settings_file_of_bytes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.toml").write_bytes(b"\xff\xfe\x00")
    assert "not TOML" in refused(capsys, "explain", "--config", folder / "a.toml")
    (folder / "a.toml").write_bytes(b"")
    assert run("explain", "--config", folder / "a.toml", capsys=capsys)[0] == 0


def test_arrays_that_do_not_fit(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from PIL import Image

    monkeypatch.chdir(folder)
    np.save("d.npy", np.ones((3, 4), np.float32))
    np.save("n.npy", np.ones((3, 4), np.float32))
    Image.fromarray(np.zeros((5, 5, 3), np.uint8)).save("c.png")
    view = ("--depth", "d.npy", "--yfov-deg", "40", "-o", "out.png")
    assert "expected uint8 sRGB of shape (3, 4, 3)" in refused(capsys, "apply", "c.png", *view)
    assert "normals are float32 of shape (3, 4)" in refused(capsys, "apply", *view, "--normals", "n.npy")
    assert "needs a radius" in refused(capsys, "apply", *view, "--depth-kind", "window")
    assert "depth kind 'eyes'" in refused(capsys, "apply", *view, "--depth-kind", "eyes", "--radius", "1")
    assert not Path("out.png").exists()


def test_no_opengl(capsys: pytest.CaptureFixture[str], folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every provider fails: exit code 3, with the reasons and the cures."""
    import dataclasses

    from ssao_gl.gl import providers

    def fail() -> Any:
        raise OSError("there is none")

    broken = {name: dataclasses.replace(each, open=fail) for name, each in providers.PROVIDERS.items()}
    monkeypatch.setattr(providers, "PROVIDERS", broken)
    code, _, err = run("render", "-o", folder / "a.png", "--size", "8x8", capsys=capsys)
    assert code == 3 and err.startswith("ssao-gl: no OpenGL could be opened") and "Try: " in err
    assert "Traceback" not in err and not list(folder.iterdir())


def test_full_disk(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """An error while the file is written leaves neither it nor a temporary one, and an older one stays."""
    import errno

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    target = folder / "a.npy"
    target.write_bytes(b"older")
    monkeypatch.setattr(np, "save", full)
    line = refused(capsys, "render", "-o", target, "--size", "8x8")
    assert f"cannot write {target}: No space left on device" in line
    assert list(folder.iterdir()) == [target] and target.read_bytes() == b"older"


@pytest.mark.parametrize("name", ["a.png", "a.npy", "a.exr", "turn.gif"])
def test_file_too_large(name: str, folder: Path) -> None:
    """As on a full disk, but for real: the system refuses after 2 KiB."""
    script = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048)); from ssao_gl.cli import main; main(sys.argv[1:])"
    options = ["--turntable", "2"] if name == "turn.gif" else []
    line = [sys.executable, "-c", script, "render", "--size", "320x240", "-o", str(folder / name), *options]
    ran = subprocess.run(line, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 2 and ran.stderr.startswith(f"ssao-gl: cannot write {folder / name}: "), ran.stderr
    assert ran.stderr.count("\n") == 1 and not list(folder.iterdir())


def test_verbose_shows_the_trace(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    code, _, err = run("-v", "explain", folder / "gone.glb", capsys=capsys)
    assert code == 2 and "Traceback" in err and "ssao-gl: " in err.splitlines()[-1]


def test_unforeseen_errors_are_one_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from ssao_gl.cli import explain

    def fail(*_: object) -> Any:
        raise KeyError("x")

    monkeypatch.setattr(explain, "plan_render", fail)
    code, _, err = run("explain", capsys=capsys)
    assert code == 2 and "unforeseen KeyError" in err and err.count("\n") == 1


def test_terminal_codes_are_not_passed_on(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    assert "\x1b" not in refused(capsys, "explain", folder / "\x1b[31mred.glb")


def command(*arguments: object, **options: Any) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "ssao_gl", *map(str, arguments)]
    # Tests that run in the background inherit an ignored Ctrl-C; a user's shell does not hand that on.
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_ctrl_c, **options)


def heed_ctrl_c() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("output", ["frames", "a.gif"])
def test_interrupted(number: int, code: int, output: str, folder: Path) -> None:
    """A turntable is stopped: whole files or none."""
    running = command("render", "--turntable", 2000, "--size", "64x48", "-o", folder / output)
    started = time.perf_counter()
    while output == "frames" and not list(folder.glob("frames/*.png")) and time.perf_counter() - started < 30:
        time.sleep(0.05)
    time.sleep(1.5 if output != "frames" else 0)
    running.send_signal(number)
    _, err = running.communicate(timeout=30)
    assert running.returncode == code, err
    assert "Traceback" not in err
    from PIL import Image

    for path in folder.rglob("*.*"):
        assert not path.name.startswith(".")
        Image.open(path).load()


@pytest.mark.parametrize("arguments", [("methods",), ("shader", "alchemy"), ("explain",)])
def test_closed_pipe(arguments: tuple[str, ...]) -> None:
    running = command(*arguments)
    assert running.stdout is not None and running.stderr is not None
    running.stdout.close()
    err = running.stderr.read()
    assert running.wait(30) == 0 and err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_full_standard_output() -> None:
    with Path("/dev/full").open("w") as full:
        ran = subprocess.run([sys.executable, "-m", "ssao_gl", "methods"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert ran.returncode == 2 and ran.stderr == "ssao-gl: standard output: No space left on device\n"


def test_locale_without_unicode() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "NO_COLOR": "1"}
    ran = subprocess.run([sys.executable, "-m", "ssao_gl", "methods"], env=environment, capture_output=True)
    assert ran.returncode == 0 and ran.stdout.isascii() and b"\x1b" not in ran.stdout
