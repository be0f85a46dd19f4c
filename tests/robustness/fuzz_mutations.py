"""Ways to break a file, by what it is made of: bytes, numbers in text, a JSON tree, the members of an archive."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import re
import struct
import zipfile
from typing import Any

import numpy as np

from .fuzz_seeds import Files

Rng = np.random.Generator

NUMBERS = (
    "0", "-1", "1", "2", "3", "7", "255", "65536", "2147483647", "-2147483648", "4294967295", "4294967296", "9223372036854775807",
    "1000000000000", "1e39", "1e-39", "-1e308", "1e400", "nan", "inf", "-inf", "0.5", "", "9" * 400, "x", "1 2 3",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 99, 2**31, 2**32 - 1, 2**63, 10**400, 1.5, -0.0, 1e308, float("nan"), float("inf"), "", "x", "0",
    "../a.bin", "/etc/passwd", "http://127.0.0.1:9/a.bin", "file:///etc/passwd", "data:;base64,AAAA", "a\n\x1b[31mb", "x" * 5000,
    [], [0], [0] * 16, [[0]], [None], [1e308] * 3, {}, {"a": 1}, {"index": 0}, [{}], [{"children": [0]}],
)  # fmt: skip
WORDS = (
    *(struct.pack("<I", word) for word in (0, 1, 2**31, 2**32 - 1, 2**16)),
    *(struct.pack("<f", x) for x in (np.nan, np.inf, 3e38, -1e-40)),
)
NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")


def mutant(files: Files, rng: Rng) -> Files:
    """A copy of a scene with its main file broken, or now and then one beside it."""
    names = list(files)
    name = names[0] if rng.random() < 0.85 else str(rng.choice(names))
    return {**files, name: broken(name, files[name], rng)}


def broken(name: str, content: bytes, rng: Rng) -> bytes:
    """One mutation, seldom more, of a kind that suits the file: what is recognisable goes further into a reader than noise."""
    suffix = name.rsplit(".", 1)[-1]
    kinds = [_bytes, _words, _truncated, _blocks]
    if suffix in ("obj", "mtl", "off", "xyz", "dae", "gltf") or (suffix in ("ply", "stl") and b"\0" not in content[:200]):
        kinds += [_numbers] * 5 + [_lines] * 3
    elif suffix in ("ply", "stl"):
        kinds += [_words] * 3
    if suffix == "ply":
        kinds += [_header] * 4
    if suffix in ("glb", "gltf"):
        kinds += [_json] * 12
    if suffix in ("zip", "3mf", "zae"):
        kinds += [_members] * 12
    if suffix in ("gz", "bz2"):
        kinds += [_packed] * 12
    for _ in range(int(rng.geometric(0.6))):
        content = kinds[rng.integers(len(kinds))](content, rng)
    return content


def _bytes(content: bytes, rng: Rng) -> bytes:
    """Bits flipped and bytes set, mostly near the start."""
    data = bytearray(content)
    for _ in range(int(rng.geometric(0.5)) if data else 0):
        at = int(rng.integers(len(data) if rng.random() < 0.5 else min(len(data), 300)))
        data[at] = int(rng.choice([0, 255, data[at] ^ (1 << int(rng.integers(8))), int(rng.integers(256))]))
    return bytes(data)


def _words(content: bytes, rng: Rng) -> bytes:
    """Four bytes in the later part made a number that readers stumble over."""
    at = int(rng.integers(len(content) // 2, max(len(content) - 3, len(content) // 2 + 1)))
    return content[:at] + WORDS[rng.integers(len(WORDS))] + content[at + 4 :]


def _truncated(content: bytes, rng: Rng) -> bytes:
    return content[: int(rng.integers(len(content) + 1))]


def _blocks(content: bytes, rng: Rng) -> bytes:
    """A piece removed, doubled, moved, or repeated many times."""
    a, b, c = sorted(int(v) for v in rng.integers(len(content) + 1, size=3))
    piece = content[a : min(b, a + 4000)]
    kind = rng.integers(4)
    if kind == 0:
        return content[:a] + content[b:]
    if kind == 1:
        return content[:b] + piece + content[b:]
    if kind == 2:
        return content[:a] + content[b:c] + piece + content[c:]
    return content[:b] + piece * int(min(300, 1 + 200_000 // max(len(piece), 1))) + content[b:]


def _numbers(content: bytes, rng: Rng) -> bytes:
    """Some of the numbers in a text replaced."""
    found = list(NUMBER.finditer(content))
    for match in reversed([found[i] for i in sorted(set(rng.integers(len(found), size=2).tolist()))] if found else []):
        content = content[: match.start()] + str(rng.choice(NUMBERS)).encode() + content[match.end() :]
    return content


def _lines(content: bytes, rng: Rng) -> bytes:
    """Lines dropped, repeated or swapped."""
    lines = content.split(b"\n")
    a, b = (int(v) for v in rng.integers(len(lines), size=2))
    kind = rng.integers(3)
    if kind == 0:
        del lines[a]
    elif kind == 1:
        lines[a:a] = [lines[b]] * int(rng.integers(1, 2000))
    else:
        lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _header(content: bytes, rng: Rng) -> bytes:
    """A PLY header with other types, counts and lines."""
    head, end, body = content.partition(b"end_header")
    if rng.random() < 0.4:
        return _numbers(head, rng) + end + body
    if rng.random() < 0.5:
        return _lines(head, rng) + end + body
    types = [b"char", b"uchar", b"short", b"ushort", b"int", b"uint", b"float", b"double", b"list uchar int", b"list uint uint"]
    old = types[rng.integers(len(types))]
    return head.replace(old, types[rng.integers(len(types))]) + end + body


def _json(content: bytes, rng: Rng) -> bytes:
    """Values of the tree replaced, removed, or swapped with others; a GLB's lengths are kept right."""
    packed = content[:4] == b"glTF" and len(content) > 28
    length = struct.unpack("<I", content[12:16])[0] if packed else len(content)
    text = content[20 : 20 + length] if packed else content
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        return _bytes(content, rng)
    for _ in range(int(rng.integers(1, 4))):
        _change(tree, rng)
    try:
        text = json.dumps(tree).encode()
    except ValueError:  # a value was put inside itself
        return _bytes(content, rng)
    if not packed:
        return text
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest


def _change(tree: Any, rng: Rng) -> None:
    places: list[tuple[Any, Any]] = []
    stack = [tree]
    while stack:
        at = stack.pop()
        keys = list(at) if isinstance(at, dict) else list(range(len(at))) if isinstance(at, list) else []
        places += [(at, key) for key in keys]
        stack += [at[key] for key in keys]
    if not places:
        return
    at, key = places[rng.integers(len(places))]
    kind = rng.integers(4)
    if kind == 0:
        del at[key]
    elif kind == 1:
        other, name = places[rng.integers(len(places))]
        at[key] = json.loads(json.dumps(other[name]))
    elif kind == 2 and isinstance(at[key], list):
        at[key] = at[key] * int(rng.integers(2, 200))
    else:
        at[key] = VALUES[rng.integers(len(VALUES))]


def _packed(content: bytes, rng: Rng) -> bytes:
    """What is in a packed file broken, and packed again."""
    packer: Any = bz2 if content[:3] == b"BZh" else gzip
    try:
        plain = packer.decompress(content)
    except Exception:
        return _bytes(content, rng)
    return bytes(packer.compress(broken("a.obj" if packer is bz2 else "a.tar", plain, rng)))


def _members(content: bytes, rng: Rng) -> bytes:
    """A member of an archive broken, and the archive made whole again."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
        members = {name: archive.read(name) for name in archive.namelist()}
    except Exception:
        return _bytes(content, rng)
    names = list(members)
    if not names:
        return content
    name = str(rng.choice(names))
    inner = name.replace(".model", ".dae")
    members[name] = broken(inner, members[name], rng)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED][rng.integers(2)]) as made:
        for key, data in members.items():
            made.writestr(key, data)
    return out.getvalue()
