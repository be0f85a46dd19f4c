"""Material libraries of OBJ files: what is said of a picture before its name (Wavefront's MTL, version 3.0)."""

from __future__ import annotations

from dataclasses import dataclass, field

from .notes import Notes

OPTIONS = {
    "-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-boost": 1, "-texres": 1, "-imfchan": 1, "-type": 1, "-clamp": 1,
    "-blendu": 1, "-blendv": 1, "-cc": 1,
}  # fmt: skip
"""Option -> most of its values; of -s, -o and -t the later ones may be left out."""
NUMBERS = {"-s": 1.0, "-o": 0.0, "-t": 0.0, "-mm": 0.0}
"""Options of numbers, with what a missing one means."""

PLACE = "ssao_gl_place"
"""Key of a line of ours, which trimesh hands on: scale and offset of u and v, and whether the picture is clamped."""


@dataclass
class PictureLine:
    """A picture and how it lies: texture coordinates are scaled, then moved."""

    name: bytes
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False
    unused: list[str] = field(default_factory=list)


def without_options(name: str, content: bytes, notes: Notes) -> bytes:
    """Return a material library whose maps are followed by the picture's name alone; other files stay as they are.

    What options say of the place of the base colour's picture follows in a line of ours.
    """
    if not name.lower().endswith(".mtl") or b" -" not in content.replace(b"\t", b" "):
        return content
    lines = []
    for line in content.split(b"\n"):
        words = line.split()
        key = words[0].lower() if words else b""
        if len(words) > 1 and words[1][:1] == b"-" and (key.startswith(b"map_") or key == b"bump"):
            picture = picture_line(line.strip()[len(key) :].strip())
            line = words[0] + b" " + picture.name
            if key == b"map_kd":
                numbers = (*picture.scale, *picture.offset, float(picture.clamp))
                line += b"\n" + " ".join([PLACE, *map(repr, numbers)]).encode()
                for option in picture.unused:
                    notes.add(f"a picture's option {option} in the material library is not applied")
        lines.append(line)
    return b"\n".join(lines)


def picture_line(rest: bytes) -> PictureLine:
    """Return what follows a map's key. The picture's name may hold spaces."""
    found = PictureLine(rest)
    while True:
        option, _, after = rest.partition(b" ")
        key = option.decode("latin-1").lower()
        if key not in OPTIONS:
            found.name = rest
            return found
        rest, values = _values(key, after.strip())
        _apply(found, key, values)


def _values(key: str, rest: bytes) -> tuple[bytes, list[bytes]]:
    """What is left after the values of an option, and these."""
    values: list[bytes] = []
    for _ in range(OPTIONS[key]):
        value, _, after = rest.partition(b" ")
        if (key in NUMBERS and _number(value) is None) or not after:
            break
        values.append(value)
        rest = after.strip()
    return rest, values


def _apply(picture: PictureLine, key: str, values: list[bytes]) -> None:
    if key == "-clamp":
        picture.clamp = values[:1] == [b"on"]
        return
    numbers = [_number(value) or 0.0 for value in values]
    first = numbers[0] if numbers else NUMBERS.get(key, 0.0)
    second = numbers[1] if len(numbers) > 1 else NUMBERS.get(key, 0.0)
    if key == "-s":
        picture.scale = (first, second)
    elif key == "-o":
        picture.offset = (first, second)
    elif (key == "-t" and any(numbers)) or (key == "-mm" and (first, second) not in ((0, 0), (0, 1))):
        picture.unused.append(key)


def _number(word: bytes) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
