"""The pass of three.js, with the real package, in a real browser."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.scene.pose import look_at

from ..browser import served_page

README = Path(__file__).parents[2] / "README.md"
SIZE = (160, 90)
RADIUS = 0.8
EYE = (3.0, 2.5, 4.0)
PAGE = """
import * as THREE from "three";
import { EffectComposer } from "three/addons/postprocessing/EffectComposer.js";
import { OutputPass } from "three/addons/postprocessing/OutputPass.js";
import { SsaoGlPass } from "./ao/ssao-gl-three.js";

const [width, height] = [160, 90];
export function drawn(options, { lens = "perspective", frames = 1, configuration = {} } = {}) {
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, ...options });
    renderer.setSize(width, height, false);
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0.25, 0.5, 0.75);
    const material = new THREE.MeshBasicMaterial({ color: 0x808080, side: THREE.DoubleSide });
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(4, 4), material);
    floor.rotation.x = -Math.PI / 2;
    const box = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), material);
    box.position.y = 0.5;
    scene.add(floor, box);
    const camera = lens === "perspective" ? new THREE.PerspectiveCamera(40, width / height, 0.5, 30)
        : new THREE.OrthographicCamera(-3.2, 3.2, 1.8, -1.8, 0.5, 30);
    camera.position.set(3, 2.5, 4);
    camera.lookAt(0, 0, 0);
    const composer = new EffectComposer(renderer);
    const pass = new SsaoGlPass(scene, camera, width, height);
    Object.assign(pass.configuration, { aoRadius: 0.8 }, configuration);
    if (configuration.color) pass.configuration.color = new THREE.Color(...configuration.color);
    composer.addPass(pass);
    composer.addPass(new OutputPass());
    for (let i = 0; i < frames; i++) composer.render();
    const gl = renderer.getContext(), pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const { memory, programs } = renderer.info, found = { error: gl.getError(), textures: memory.textures };
    composer.dispose();
    pass.dispose();
    renderer.dispose();
    renderer.forceContextLoss();
    return { pixels: Array.from(pixels), ...found };
}
"""


def readme_block() -> str:
    """The README's block for three.js, as a module that runs it for a renderer, a scene and a camera, and returns its composer."""
    section = README.read_text("utf-8").split("\n## In three.js, in the browser, in a notebook\n", 1)[1].split("\n## ", 1)[0]
    (block,) = re.findall(r"```js\n(.*?)```", section, re.DOTALL)
    assert len([line for line in block.splitlines() if line.strip()]) <= 12, "a newcomer's lines"
    imports, code = block.split("\n\n", 1)
    return f"{imports}\nexport default function (renderer, scene, camera, width, height) {{\n{code}\nreturn composer; }}\n"


@pytest.fixture(scope="module")
def three() -> Path:
    folders = [Path(folder) / "three" for folder in os.environ.get("NODE_PATH", "").split(os.pathsep) if folder]
    found = next((folder for folder in folders if (folder / "package.json").exists()), None)
    if found is None:
        pytest.skip("no npm package three in NODE_PATH")
    return found


@pytest.fixture(scope="module")
def drawn(browser: Any, three: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Draw with three.js: RGB (h, w, 3) uint8, row 0 on top."""
    folder = tmp_path_factory.mktemp("site")
    files = {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in ao.export(folder / "ao", target="three", method=ao.Bitmask(radius=1.0))}  # fmt: skip
    modules = [
        *(three / "build").glob("three.*.js"),
        *(three / "examples/jsm/postprocessing").glob("*.js"),
        *(three / "examples/jsm/shaders").glob("*.js"),
    ]
    files |= {f"three/{path.relative_to(three).as_posix()}": path.read_text("utf-8") for path in modules}
    imports = '{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}'
    files["index.html"] = f'<!doctype html><script type="importmap">{imports}</script>'
    files["page.js"] = PAGE
    files["readme.js"] = readme_block()
    page = served_page(browser, files)

    def draw(options: dict[str, Any] | None = None, **more: Any) -> np.ndarray:
        found = page.evaluate(
            "async ([options, more]) => (await import('/page.js')).drawn(options, more)",
            [{"antialias": False} | (options or {}), more],
        )
        assert found["error"] == 0
        return np.array(found["pixels"], np.uint8).reshape(SIZE[1], SIZE[0], 4)[::-1, :, :3]

    draw.page = page  # type: ignore[attr-defined]
    yield draw
    page.close()


def expected(camera: ao.Camera) -> ao.Picture:
    """The same scene by Python, whose normals are rebuilt from depth likewise."""
    corners = np.array([[x, 0, z] for x in (-2, 2) for z in (-2, 2)], np.float32)
    import trimesh

    box = trimesh.creation.box((1, 1, 1))
    box.apply_translation((0, 0.5, 0))
    floor = trimesh.Trimesh(corners, [[0, 1, 2], [2, 1, 3]], process=False)
    with ao.Renderer() as renderer:
        depth = renderer.render(ao.as_scene(trimesh.Scene([floor, box])), camera, SIZE, ao.Settings(), aovs=("depth",)).depth
        return renderer.apply(depth, camera, settings=ao.Settings(method=ao.Bitmask(radius=RADIUS)))


@pytest.mark.parametrize("lens", ["perspective", "orthographic"])
@pytest.mark.parametrize("reversed_depth", [False, True], ids=["plain", "reversed"])
def test_visibility_is_that_of_python(lens: str, reversed_depth: bool, drawn: Any) -> None:
    pose = look_at(EYE, (0, 0, 0), (0, 1, 0))
    camera = (
        ao.Camera.perspective(np.radians(40), 0.5, 30, pose)
        if lens == "perspective"
        else ao.Camera.orthographic(3.6, 0.5, 30, pose)
    )
    picture = expected(camera)
    shown = drawn({"reversedDepthBuffer": reversed_depth}, lens=lens, configuration={"renderMode": "AO"})
    # OutputPass has encoded it as sRGB.
    seen = np.asarray(shown[..., 0], float) / 255
    linear = np.where(seen <= 0.04045, seen / 12.92, ((seen + 0.055) / 1.055) ** 2.4)
    error = np.abs(linear - picture.visibility)
    assert picture.visibility.min() < 0.6 and np.quantile(error, 0.98) < 0.02 and error.mean() < 0.004


def test_occlusion_multiplies_linear_light(drawn: Any) -> None:
    def light(shown: np.ndarray) -> np.ndarray:
        seen = shown / 255
        return np.where(seen <= 0.04045, seen / 12.92, ((seen + 0.055) / 1.055) ** 2.4)

    open_, dimmed = (light(drawn(configuration={"intensity": value})) for value in (0, 1))
    visibility = light(drawn(configuration={"renderMode": "AO"}))
    assert np.abs(open_ * visibility - dimmed).max() < 0.01 and (dimmed < open_ - 0.02).any()
    red = light(drawn(configuration={"color": [1, 0, 0]}))
    assert np.abs(red[..., 1] - dimmed[..., 1]).max() < 0.01 and (red[..., 0] > dimmed[..., 0] + 0.02).any()


def test_live_settings_and_many_frames(drawn: Any) -> None:
    once = drawn(configuration={"renderMode": "AO"})
    assert (drawn(frames=5, configuration={"renderMode": "AO"}) == once).all()
    assert drawn(configuration={"renderMode": "AO", "aoRadius": 0.2}).mean() > once.mean() + 1


@pytest.mark.parametrize(
    ("options", "more", "text"),
    [
        ({"logarithmicDepthBuffer": True}, {}, "logarithmic depth is not read"),
        ({}, {"configuration": {"renderMode": "Split"}}, "must be one of Combined,AO"),
        ({}, {"configuration": {"aoRadius": -1}}, "radius=-1: is out of range"),
    ],
)
def test_mistakes_are_told(options: dict[str, Any], more: dict[str, Any], text: str, drawn: Any) -> None:
    with pytest.raises(Exception, match=text):
        drawn(options, **more)


def test_the_readmes_block_draws(drawn: Any) -> None:
    found = drawn.page.evaluate("""async () => {
        const THREE = await import("three"), { default: readme } = await import("/readme.js");
        const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
        renderer.setSize(64, 36, false);
        const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(50, 64 / 36, 0.1, 30);
        const material = new THREE.MeshBasicMaterial({ color: 0xffffff, side: THREE.DoubleSide });
        for (const turn of [0, -Math.PI / 2]) {
            const wall = scene.add(new THREE.Mesh(new THREE.PlaneGeometry(4, 4), material)).children.at(-1);
            wall.rotation.x = turn;
        }
        camera.position.set(0.5, 1, 2);
        camera.lookAt(0, 0, 0);
        const composer = readme(renderer, scene, camera, 64, 36);
        await new Promise((done) => setTimeout(done, 300));
        renderer.setAnimationLoop(null);
        composer.render();
        const gl = renderer.getContext(), pixels = new Uint8Array(4 * 64 * 36);
        gl.readPixels(0, 0, 64, 36, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        renderer.forceContextLoss();
        return Array.from(pixels);
    }""")
    shown = np.array(found, np.uint8).reshape(36, 64, 4)[..., 0]
    assert shown.max() == 255 and 20 < shown[shown > 0].min() < 235, "walls darken their crease"
