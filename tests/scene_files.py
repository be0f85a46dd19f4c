"""Scene files built by hand, and what one can do to them: GLB, PLY, STL, OBJ, archives."""

from __future__ import annotations

import io
import json
import struct
import tarfile
import zipfile
from typing import Any

import numpy as np

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
