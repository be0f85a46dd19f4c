"""Object space beside screen space: rays, ambient occlusion volumes, elements, and three methods that know a depth buffer alone.

Without a scene it draws the embedded one. `--scenes sponza.glb:atrium,...` (NAME.cam.json beside it) makes one sheet, a row each.
Times are of the CPU, of all threads, of what comes after the G-buffer: they say as much on a machine that has other things to do.
"""

import argparse
import dataclasses
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import ssao_gl as ao
from ssao_gl.loaders.camera_files import load_camera
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.truth import Tracing, trace

SCREEN = ("aov", "volumetric", "crytek", "bitmask")
ORDER = ("rays", "aov", "volumetric", "crytek", "baked elements", "bitmask")
RAYS = 512
"""A pixel, for those that the others are measured against; in small pictures fewer would do."""


@dataclass
class Panel:
    """Visibility (h, w) by a method. prepared: seconds of what is made once; frame: of each frame."""

    name: str
    visibility: np.ndarray
    prepared: float
    frame: float
    rmse: float = 0.0

    @property
    def caption(self) -> str:
        error = f"±{self.rmse:.3f}" if self.name == "rays" else f"RMSE {self.rmse:.3f}"
        return f"{self.name}: {error}, {_time(self.frame)}" + (
            f" (+ {_time(self.prepared)} once)" if self.prepared > 0.2 else ""
        )


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s" if seconds >= 1 else f"{1000 * seconds:.0f} ms"


def cpu(work: Callable[[], object]) -> tuple[object, float]:
    """Do work, and return its result and the seconds that all threads took."""
    began = time.process_time()
    result = work()
    return result, time.process_time() - began


def drawn(renderer: ao.Renderer, scene: ao.Scene, camera: ao.Camera, size: tuple[int, int], settings: ao.Settings) -> Panel:
    """A method of the renderer. What the first frame takes more than later ones is its preparation."""

    def seconds(aov: str) -> float:
        again = renderer.frame(scene, camera, size, settings, aovs=(aov,))

        def frame() -> None:
            again()
            with renderer.ctx.current():
                renderer.ctx.mgl.finish()

        frame()
        return float(np.median([cpu(frame)[1] for _ in range(3)]))

    renderer.render(scene, camera, size, ao.Settings(), aovs=("visibility",))  # the scene is on the GPU, for every method alike
    picture, first = cpu(lambda: renderer.render(scene, camera, size, settings, aovs=("visibility",)))
    later = seconds("visibility")
    made_once = first - later if settings.method.name == "aov" else 0.0
    return Panel(settings.method.name, picture.visibility, made_once, later - seconds("depth"))


def panels(renderer: ao.Renderer, scene: ao.Scene, camera: ao.Camera, size: tuple[int, int]) -> Iterator[Panel]:
    radius = camera.ao_radius or scene.default_radius()
    tracing = Tracing(radius=radius, spp=RAYS if size[0] > 200 else 16)
    truth, seconds = cpu(lambda: trace(scene, camera, size, tracing))
    yield Panel("rays", truth.visibility, 0.0, seconds, truth.noise)
    for name in SCREEN:
        method = dataclasses.replace(ao.method(name), radius=radius)
        yield drawn(renderer, scene, camera, size, ao.Settings(method=method))
    baked, seconds = cpu(lambda: ao.bake(scene, ao.Baking(radius=radius, by="elements"), to=ao.Vertices(attribute="_AO")))
    with tempfile.TemporaryDirectory() as folder:
        baked.save(Path(folder) / "baked.glb")
        kept = ao.load_scene(Path(folder) / "baked.glb")
    panel = drawn(renderer, kept, camera, size, ao.Settings(method=ao.method("baked")))
    yield dataclasses.replace(panel, name="baked elements", prepared=seconds)


def measured(renderer: ao.Renderer, scene: ao.Scene, camera: ao.Camera, size: tuple[int, int]) -> list[Panel]:
    """All panels in their order, each with its error against the rays on what is not background."""
    made = {panel.name: panel for panel in panels(renderer, scene, camera, size)}
    seen = renderer.render(scene, camera, size, ao.Settings(), aovs=("depth",)).depth > 0
    for panel in made.values():
        if panel.name != "rays":
            panel.rmse = float(np.sqrt(np.mean((panel.visibility - made["rays"].visibility)[seen].astype(np.float64) ** 2)))
        print(panel.caption, flush=True)
    return [made[name] for name in ORDER]


def sheet(rows: Sequence[Sequence[Panel]], size: tuple[int, int]) -> Image.Image:
    """One picture of all panels at half of their size, each over its caption."""
    w, h, line, gap = size[0] // 2, size[1] // 2, 18, 4
    whole = Image.new("L", ((w + gap) * len(ORDER) - gap, (h + line + gap) * len(rows) - gap), 255)
    pen, font = ImageDraw.Draw(whole), ImageFont.load_default(13)
    for y, row in enumerate(rows):
        for x, panel in enumerate(row):
            picture = Image.fromarray(np.round(255 * panel.visibility).astype(np.uint8)).resize((w, h), Image.Resampling.BOX)
            at = x * (w + gap), y * (h + line + gap)
            whole.paste(picture, at)
            pen.text((at[0] + 1, at[1] + h + 1), panel.caption, 0, font)
    return whole


def main(folder: Path, size: tuple[int, int], scenes: Sequence[str]) -> None:
    rows = []
    with ao.Renderer() as renderer:
        for place in scenes:
            file, camera = place.rsplit(":", 1)
            print(place)
            eye = load_camera(f"{Path(file).with_suffix('.cam.json')}:{camera}", size)
            rows.append(measured(renderer, ao.load_scene(file), eye, size))
        if rows:
            sheet(rows, size).save(folder / "16_object_space.png", optimize=True)
            return
        scene = default_scene()
        for panel in measured(renderer, scene, scene.cameras[0], size):
            Image.fromarray(np.round(255 * panel.visibility).astype(np.uint8)).save(
                folder / f"11_{panel.name.replace(' ', '_')}.png"
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels of each panel (default: 640x360)")
    parser.add_argument("--scenes", metavar="FILE:CAMERA,...", default="", help="scenes of a sheet, a row each")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height), [one for one in arguments.scenes.split(",") if one])
