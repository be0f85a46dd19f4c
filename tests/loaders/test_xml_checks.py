"""3MF and COLLADA are checked before their readers see them, which need other packages; and formats that are not read."""

from __future__ import annotations

import importlib.util
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from ssao_gl.errors import SceneError
from ssao_gl.loaders import mesh_files
from ssao_gl.loaders.load import load_scene
from ssao_gl.loaders.xml_checks import check_3mf, check_dae

from ..robustness.fuzz_seeds import DAE, seeds
from ..scene_files import zipped

MESH = "<mesh><vertices/><triangles/></mesh>"
OBJECT = f'<object id="1">{MESH}</object>'
LAUGHS = (
    '<!DOCTYPE x [<!ENTITY a "ha">' + "".join(f'<!ENTITY a{i} "{f"&a{i - 1 if i else str()};" * 10}">' for i in range(9)) + "]>"
)
OUTSIDE = '<!DOCTYPE x [<!ENTITY x SYSTEM "file:///etc/passwd">]>'


def model(resources: str, build: str = '<item objectid="1"/>', head: str = "", encoding: str = "UTF-8") -> dict[str, bytes]:
    text = (
        f'<?xml version="1.0" encoding="{encoding}"?>{head}<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        f"<resources>{resources}</resources><build>{build}</build></model>"
    )
    return {"3D/3dmodel.model": text.encode()}


def made_of(name: int, *parts: int) -> str:
    return (
        f'<object id="{name}"><components>' + "".join(f'<component objectid="{p}"/>' for p in parts) + "</components></object>"
    )


MODELS: dict[str, tuple[dict[str, bytes], str]] = {
    "entities": (model(OBJECT, head=LAUGHS), "document type"),
    "a file as entity": (model(OBJECT + "&x;", head=OUTSIDE), "document type"),
    "entities in UTF-16": ({"a.model": model(OBJECT, head=LAUGHS, encoding="UTF-16")["3D/3dmodel.model"].decode().encode("utf-16")}, "document type"),
    "another encoding": (model(OBJECT, encoding="UTF-7"), "in the encoding 'UTF-7'"),
    "cycle": (model(OBJECT + made_of(2, 3) + made_of(3, 2), '<item objectid="2"/>'), "'2' is part of itself"),
    "itself": (model(made_of(1, 1)), "'1' is part of itself"),
    "parts of parts": (model(OBJECT + "".join(made_of(i, i - 1, i - 1) for i in range(2, 60)), '<item objectid="59"/>'), "more than 5000 parts"),
    "chain": (model(OBJECT + "".join(made_of(i, i - 1) for i in range(2, 900)), '<item objectid="899"/>'), "more than 200 levels"),
    "items": (model(OBJECT, '<item objectid="1"/>' * 5001), "more than 5000 parts"),
    "a file again and again": (
        model(made_of(2, 1).replace("/>", ' path="/b.model"/>') * 400) | {"b.model": model(OBJECT, head="<!--" + "x" * 400_000 + "-->")["3D/3dmodel.model"]},
        "MiB of geometry",
    ),
    "deep": (model("<a>" * 100_000 + "</a>" * 100_000), "nested more than 200"),
    "cut": ({"a.model": model(OBJECT)["3D/3dmodel.model"][:-9]}, "cannot be read"),
    "another root": ({"a.model": b"<html xmlns='x'/>"}, "begins with 'html'"),
}  # fmt: skip


@pytest.mark.parametrize("case", MODELS)
def test_models_refused(case: str) -> None:
    with pytest.raises(SceneError, match=MODELS[case][1]):
        check_3mf(MODELS[case][0])


def changed(old: str, new: str) -> bytes:
    assert old in DAE
    return DAE.replace(old, new).encode()


NODE = '<node id="n"><instance_geometry url="#g"/></node>'
INSTANCE = '<instance_node url="#n"/>'
LIBRARY = NODE + "".join(
    f'<node id="n{i}">{f"""<instance_node url="#n{i - 1 if i else str()}"/>""" * 2}</node>' for i in range(40)
)
DOCUMENTS: dict[str, tuple[bytes, str]] = {
    "entities": (changed("<COLLADA", LAUGHS + "<COLLADA"), "document type"),
    "a file as entity": (changed("<COLLADA", OUTSIDE + "<COLLADA"), "document type"),
    "nodes of nodes": (changed(INSTANCE, INSTANCE.replace("#n", "#n39")).replace(NODE.encode(), LIBRARY.encode()), "more than 5000 parts"),
    "itself": (changed(NODE, NODE.replace("instance_geometry", "instance_node").replace("#g", "#n")), "part of itself"),
    "its own ancestor": (changed(INSTANCE, INSTANCE.replace("#n", "#r")), "part of itself"),
    "geometry again and again": (
        changed("<p>0 0 1 1 2 2</p>", f"<p>{'0 0 1 1 2 2 ' * 50_000}</p>").replace(INSTANCE.encode(), b'<instance_geometry url="#g"/>' * 200),
        "MiB of geometry",
    ),
    "corners": (changed("<vcount>4</vcount>", "<vcount>2000000000</vcount>"), "announces 2000000000 corners"),
    "corners of text": (changed("<vcount>4</vcount>", "<vcount>many</vcount>"), "no number"),
    "corners by a reference": (changed("<vcount>4</vcount>", "<vcount>200<!-- -->000&#48;000</vcount>"), "announces 2000000000 corners"),
    "deep": (changed(INSTANCE, "<node>" * 300 + "</node>" * 300), "nested more than 200"),
    "no namespace": (b"<COLLADA/>", "expected 'COLLADA' in a namespace"),
    "ZIP": (zipped(a__dae=DAE.encode()), "but a ZIP archive"),
    "ZIP at its end": (DAE.encode() + zipped(a__dae=DAE.encode()), "but a ZIP archive"),
}  # fmt: skip


@pytest.mark.parametrize("case", DOCUMENTS)
def test_documents_refused(case: str) -> None:
    with pytest.raises(SceneError, match=DOCUMENTS[case][1]):
        check_dae(DOCUMENTS[case][0])


def test_what_is_whole_passes() -> None:
    check_dae(DAE.encode())
    check_3mf(model(OBJECT + made_of(2, 1, 1), '<item objectid="2"/>' * 1000))


@pytest.mark.parametrize(
    ("name", "package", "module"), [("3mf", "lxml", "lxml"), ("dae", "pycollada", "collada"), ("zae", "pycollada", "collada")]
)
def test_read_or_told_what_is_missing(name: str, package: str, module: str, tmp_path: Path) -> None:
    for file, content in seeds(only=name)[name].items():
        (tmp_path / file).write_bytes(content)
    path = tmp_path / f"a.{name}"
    if importlib.util.find_spec(module) is None:
        with pytest.raises(SceneError, match=f"pip install {package}"):
            load_scene(path)
    else:
        assert load_scene(path).triangles in (3, 6)


def test_formats_that_cannot_be_guarded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What trimesh could read with more packages, in native code or without bounds."""
    formats: Callable[[], set[str]] = mesh_files.mesh_formats
    monkeypatch.setattr(mesh_files, "mesh_formats", lambda: formats() | {"step", "3dxml"})
    for kind in ("step", "3dxml"):
        (tmp_path / f"a.{kind}").write_bytes(b"x")
        with pytest.raises(SceneError, match=f"format '.{kind}' is not read"):
            load_scene(tmp_path / f"a.{kind}")
        with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
            archive.writestr(f"a.{kind}", b"x")
        with pytest.raises(SceneError, match="holds 0 mesh files"):
            load_scene(tmp_path / "a.zip")
