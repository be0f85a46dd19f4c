"""Colours of 3MF models: materials and colour groups, of objects and of triangles."""

from __future__ import annotations

import numpy as np

from ssao_gl.loaders.notes import Notes
from ssao_gl.loaders.threemf_colors import object_colors

NAMESPACES = (
    'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
    'xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"'
)
PAINTS = (
    '<basematerials id="5"><base name="red" displaycolor="#FF0000"/><base name="dim" displaycolor="#0000FF80"/></basematerials>'
    '<m:colorgroup id="6"><m:color color="#00FF00FF"/><m:color color="#000000"/></m:colorgroup>'
)


def colors_of(resources: str) -> tuple[list[tuple[int, np.ndarray | None]], tuple[str, ...]]:
    notes = Notes()
    model = f"<model {NAMESPACES}><resources>{resources}</resources><build/></model>"
    return object_colors({"3D/3dmodel.model": model.encode()}, notes), notes.lines


def made(attributes: str, triangles: str) -> str:
    return f'<object id="1" {attributes}><mesh><vertices/><triangles>{triangles}</triangles></mesh></object>'


def test_an_object_and_its_triangles_have_colours() -> None:
    triangles = '<triangle v1="0" v2="1" v3="2"/>' + '<triangle v1="0" v2="1" v3="2" pid="6" p1="0"/>'
    ((count, found),), lines = colors_of(PAINTS + made('pid="5" pindex="1"', triangles))
    assert count == 2 and found is not None and found.tolist() == [[0, 0, 255, 128], [0, 255, 0, 255]] and lines == ()


def test_corners_are_averaged() -> None:
    ((_, found),), _ = colors_of(PAINTS + made("", '<triangle v1="0" v2="1" v3="2" pid="6" p1="0" p2="1" p3="1"/>'))
    assert found is not None and found.tolist() == [[0, 85, 0, 255]]


def test_what_has_no_colour_stays_so() -> None:
    plain = made("", '<triangle v1="0" v2="1" v3="2"/>')
    parts = '<object id="9"><components><component objectid="1"/></components></object>'
    wrong = made('pid="77" pindex="3"', '<triangle v1="0" v2="1" v3="2" p1="x"/>')
    found, _ = colors_of(PAINTS + plain + parts + wrong)
    assert found == [(1, None), (1, None)]


def test_what_is_not_read_is_said() -> None:
    _, lines = colors_of('<m:texture2dgroup id="8" texid="1"/>' + made("", '<triangle v1="0" v2="1" v3="2"/>'))
    assert len(lines) == 1 and "texture2dgroup" in lines[0]


def test_broken_colours_are_white() -> None:
    group = '<m:colorgroup id="6"><m:color color="red"/></m:colorgroup>'
    ((_, found),), _ = colors_of(group + made('pid="6" pindex="0"', '<triangle v1="0" v2="1" v3="2"/>'))
    assert found is not None and found.tolist() == [[255] * 4]
