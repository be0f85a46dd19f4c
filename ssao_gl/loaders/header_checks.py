"""What a mesh file claims, checked before trimesh believes it: counts against sizes, parts against sensible numbers.

Each check takes a file and its size, raises SceneError, and gives the file as trimesh should read it.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from typing import BinaryIO

from ..errors import SceneError
from .ply_polygons import TYPES, triangulated
from .ply_spelling import respelled, unstripped

MAX_HEADER = 1 << 20
MAX_PROPERTIES = 1000
"""Of a PLY file, over all elements; trimesh looks at all lists for each of them."""
MAX_MATERIALS = 4000
RELATIVE = re.compile(rb"(?m)^ *f [^\n]*[ /]-\d")
"""A face of an OBJ file with an index that counts back."""
ZERO = re.compile(rb"(?m)^ *f (?:[^\n]*[ /])?0+(?:[ /]|$)")
"""A face with an index that OBJ files do not have."""

SIGNATURES: tuple[tuple[bytes, str, frozenset[str]], ...] = (
    (b"\x89PNG\r\n", "a PNG picture", frozenset()),
    (b"\xff\xd8\xff", "a JPEG picture", frozenset()),
    (b"%PDF", "a PDF document", frozenset()),
    (b"<!DOCTYPE html", "a web page", frozenset()),
    (b"<html", "a web page", frozenset()),
    (b"version https://git-lfs", "a Git LFS pointer (git lfs pull fetches the file)", frozenset()),
    (b"\x1f\x8b", "packed by gzip", frozenset({"tar.gz", "gz"})),
    (b"PK\x03\x04", "a ZIP archive", frozenset({"zip", "3mf", "zae"})),
    (b"glTF", "a GLB file", frozenset({"glb"})),
    (b"ply\n", "a PLY file", frozenset({"ply"})),
    (b"ply\r", "a PLY file", frozenset({"ply"})),
)
"""How files begin that are often misnamed: the bytes, what it is, and the formats that may begin so."""


def check_signature(head: bytes, kind: str) -> None:
    """Raises SceneError when a file begins as one of another format does."""
    for begin, what, kinds in SIGNATURES:
        if head.lower().startswith(begin.lower()) and kind not in kinds:
            raise SceneError(f"is not a .{kind} file but {what}")


def check_stl(file: BinaryIO, size: int) -> BinaryIO:
    """Binary STL is 84 bytes and 50 a triangle; anything else must be text, which begins with 'solid'."""
    head = file.read(84)
    file.seek(0)
    expected = 84 + 50 * int.from_bytes(head[80:84], "little")
    if size != expected and not head.lstrip().lower().startswith(b"solid"):
        told = f"announces {(expected - 84) // 50} triangles, {expected} bytes," if len(head) == 84 else "is too short:"
        raise SceneError(f"{told} but has {size} bytes; it is truncated or broken")
    if size == expected:
        return file
    # One solid of all: trimesh takes quadratic time to name them.
    return io.BytesIO(b"solid\n" + re.sub(rb"(?im)^[ \t]*(end)?solid.*$", b"", _text(file)) + b"\nendsolid\n")


def check_obj(file: BinaryIO, size: int) -> BinaryIO:
    """Likewise for parts of different materials, which cannot be put together."""
    text = _text(file).replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\t", b" ").replace(b"\\\n", b"")
    text = re.sub(rb" #[^\n]*", b"", text)  # after a face trimesh takes a comment for a part of it
    materials = {name.strip() for name in re.findall(rb"usemtl ([^\n]*)", text)}
    if len(materials) > MAX_MATERIALS:
        raise SceneError(f"has {len(materials)} materials; at most {MAX_MATERIALS} can be read in sensible time")
    if ZERO.search(text):
        raise SceneError("has a face with index 0; OBJ files count from 1 (or back from -1)")
    if re.search(rb"(?m)^ *l ", text) and not re.search(rb"(?m)^ *[fp] ", text):
        raise SceneError("holds no triangles, only lines")
    return io.BytesIO(_absolute(text) if RELATIVE.search(text) else text)


def _absolute(text: bytes) -> bytes:
    """Indices of an OBJ file that count back from the latest vertex, from the first one: trimesh takes them for others."""
    counts = {b"v": 0, b"vt": 0, b"vn": 0}

    def corner(word: bytes, number: int) -> bytes:
        parts = word.split(b"/")
        for place, (part, count) in enumerate(zip(parts, counts.values(), strict=False)):
            if part.startswith(b"-") and part[1:].isdigit():
                index = count + 1 - int(part[1:12])
                if index < 1:
                    raise SceneError(f"line {number}: '{word.decode('ascii', 'replace')}' counts back past the first one")
                parts[place] = b"%d" % index
        return b"/".join(parts)

    lines = text.split(b"\n")
    for number, line in enumerate(lines, 1):
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        elif words and words[0] == b"f" and b"-" in line:
            lines[number - 1] = b" ".join([b"f", *(corner(word, number) for word in words[1:])])
    return b"\n".join(lines)


def check_text(file: BinaryIO, size: int) -> BinaryIO:
    """In an encoding that needs no guessing."""
    return io.BytesIO(_text(file))


def _text(file: BinaryIO) -> bytes:
    """As UTF-8. Numbers and words are ASCII; what the others are matters little, but must not be guessed from statistics."""
    data = file.read()
    try:
        data.decode()
    except UnicodeDecodeError:
        wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
        return data.decode("utf-16" if wide else "latin-1", "replace").encode()
    return data


def check_ply(file: BinaryIO, size: int) -> BinaryIO:
    """Elements that a header announces must fit into the bytes after it, lists being empty."""
    head = file.read(MAX_HEADER)
    file.seek(0)
    end = head.find(b"end_header")
    if not head.startswith(b"ply") or end < 0:
        raise SceneError("has no complete PLY header ('ply' ... 'end_header'); it is truncated or broken")
    text = b"format ascii" in head[:end]
    left = size - head.find(b"\n", end) - 1
    needed, count, properties, name = 0, 0, 0, ""
    for line in head[:end].decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            name, count = words[1], int(words[2])
        elif words[:1] == ["property"]:
            properties += 1
            needed += count * (2 if text else int(TYPES[words[2] if words[1] == "list" else words[1]][1]))
        if count < 0 or needed > left + 1:  # the last line may lack its end
            raise SceneError(f"announces {count} of '{name}', more than its {left} bytes can hold; it is truncated or broken")
    if properties > MAX_PROPERTIES:
        raise SceneError(f"has {properties} properties; at most {MAX_PROPERTIES} can be read in sensible time")
    header = head[: size - left]
    spelled = respelled(header)
    if spelled != header:
        file.seek(len(header))
        file, size, header = io.BytesIO(spelled + file.read()), size + len(spelled) - len(header), spelled
    if b"element tristrips" in header:
        return unstripped(file, header)
    file.seek(0)
    return file if text else triangulated(file, header, size)


CHECKS: Mapping[str, Callable[[BinaryIO, int], BinaryIO]] = {
    "stl": check_stl,
    "stl_ascii": check_stl,
    "ply": check_ply,
    "obj": check_obj,
    "off": check_text,
    "xyz": check_text,
}
"""By format."""
