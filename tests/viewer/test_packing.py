"""What a page of a scene holds."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import json
import re

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SceneError
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.viewer.packing import packed_scene
from ssao_gl.viewer.page import OWN, shown_looks, viewer_page

from ..shapes import look_at
from ..volumes import ball

SIZE = (64, 48)


def unpacked(data: bytes) -> tuple[dict, bytes]:
    line, arrays = gzip.decompress(data).split(b"\n", 1)
    return json.loads(line), arrays


def array(place: dict, arrays: bytes) -> np.ndarray:
    dtype = np.dtype(place["type"])
    return np.frombuffer(arrays, dtype, place["length"], place["at"])


def test_geometry_comes_back_about_the_middle_far_from_the_origin() -> None:
    scene = default_scene()
    far = dataclasses.replace(
        scene, meshes=[dataclasses.replace(mesh, transforms=mesh.transforms + 1e7 * np.eye(4)[:, 3:] * np.eye(4)[3]) for mesh in scene.meshes]
    )  # fmt: skip
    for one in (scene, far):
        head, arrays = unpacked(packed_scene(one, SIZE))
        assert head["contents"] == scene.contents and len(head["meshes"]) == len(scene.drawn)
        middle = one.bounds.mean(0)
        for mesh, packed in zip(one.drawn, head["meshes"], strict=True):
            assert np.array_equal(array(packed["positions"], arrays).reshape(-1, 3), mesh.positions)
            assert np.array_equal(array(packed["triangles"], arrays).reshape(-1, 3), mesh.triangles)
            places = array(packed["places"], arrays).reshape(-1, 4, 4).transpose(0, 2, 1)
            assert np.abs(places[:, :3, 3] + middle - mesh.transforms[:, :3, 3]).max() < 1e-5
        pose = np.reshape(head["cameras"][0]["pose"], (4, 4)).T
        camera = (one.cameras or [one.default_camera(SIZE)])[0]
        assert np.allclose(pose[:3, 3] + middle, camera.pose[:3, 3])


def test_spheres_and_lenses() -> None:
    spheres = ao.Spheres(
        np.array([[0, 0, 0], [1, 2, 3]]), np.array([0.5, 1]), np.array([[9, 8, 7, 255], [1, 2, 3, 255]], np.uint8)
    )
    cameras = [
        Camera.orthographic(3, 0.1, 9, look_at((0, 0, 5), (0, 0, 0))),
        Camera.pinhole(50, 50, 30, 20, SIZE),
    ]
    head, arrays = unpacked(packed_scene(ao.Scene(spheres=[spheres], cameras=cameras), SIZE))
    (packed,) = head["spheres"]
    assert np.array_equal(array(packed["balls"], arrays), [0, 0, 0, 0.5, 1, 2, 3, 1])
    assert np.array_equal(array(packed["colors"], arrays), [9, 8, 7, 255, 1, 2, 3, 255])
    assert head["cameras"][0]["height"] == 3
    assert np.allclose(np.reshape(head["cameras"][1]["matrix"], (4, 4)).T, cameras[1].lens.matrix(SIZE))


def test_volumes_are_refused_in_one_line() -> None:
    with pytest.raises(SceneError, match="volumes cannot be shown in the browser"):
        packed_scene(ao.Scene(volumes=[ball()]), SIZE)


def test_the_look_that_was_asked_for_is_the_first() -> None:
    assert next(iter(shown_looks(None))) == "bitmask medium"
    assert next(iter(shown_looks(ao.Settings(method=ao.method("hbao"))))).startswith("hbao")
    own = shown_looks(ao.Settings(method=dataclasses.replace(ao.Bitmask(), steps=7, radius=0.2)))
    assert next(iter(own)) == OWN and own[OWN]["live"]["radius"]["value"] == 0.2 and len(own) > 10


def test_a_page_needs_no_network_and_no_name_breaks_out_of_it() -> None:
    name = "</script><script>alert(1)</script><!-- &"
    scene = dataclasses.replace(default_scene(), name=name)
    page = viewer_page(scene, SIZE)
    assert page == viewer_page(scene, SIZE), "the same bytes"
    assert not re.search(r"""(src|href)=|import\(|url\(|https?://""", page)
    assert page.count("<script") == 3 == page.count("</script>") and "alert" not in re.sub(r"<title>.*?</title>", "", page)
    packed = re.search(r'id="scene">([^<]*)<', page)
    assert packed and unpacked(base64.b64decode(packed[1]))[0]["name"] == name
