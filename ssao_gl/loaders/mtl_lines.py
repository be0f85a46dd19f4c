"""Material libraries of OBJ files: names of pictures without the options before them (Wavefront's MTL, version 3.0)."""

from __future__ import annotations

from .notes import Notes

OPTIONS = {
    "-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-boost": 1, "-texres": 1, "-imfchan": 1, "-type": 1, "-clamp": 1,
    "-blendu": 1, "-blendv": 1, "-cc": 1,
}  # fmt: skip
"""Option -> most of its values; of -s, -o and -t the later ones may be left out."""
NEUTRAL = {"-s": 1.0, "-o": 0.0, "-t": 0.0}
"""What changes nothing."""


def without_options(name: str, content: bytes, notes: Notes) -> bytes:
    """Return a material library whose maps are followed by the picture's name alone; other files stay as they are."""
    if not name.lower().endswith(".mtl") or b" -" not in content.replace(b"\t", b" "):
        return content
    lines = content.split(b"\n")
    for number, line in enumerate(lines):
        words = line.split()
        if len(words) > 1 and words[1][:1] == b"-" and (words[0].lower().startswith(b"map_") or words[0].lower() == b"bump"):
            lines[number] = words[0] + b" " + _picture(line.strip()[len(words[0]) :].strip(), notes)
    return b"\n".join(lines)


def _picture(rest: bytes, notes: Notes) -> bytes:
    """The name, which may hold spaces."""
    while True:
        option, _, after = rest.partition(b" ")
        key = option.decode("latin-1").lower()
        if key not in OPTIONS:
            return rest
        rest = after.strip()
        for _ in range(OPTIONS[key]):
            value, _, after = rest.partition(b" ")
            number = _number(value)
            if (number is None and key in NEUTRAL) or not after:
                break
            if key in NEUTRAL and number != NEUTRAL[key]:
                notes.add(f"a picture's option {key} in the material library is not applied")
            rest = after.strip()


def _number(word: bytes) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
