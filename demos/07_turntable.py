"""A turntable: one Renderer for many frames, so that programs, textures and the mesh stay on the GPU."""

import argparse
import time
from pathlib import Path

import numpy as np

import ssao_gl as ao
from ssao_gl.render.picture import save_animation
from ssao_gl.scene.sample_scene import default_scene

FRAMES = 24


def main(folder: Path, size: tuple[int, int]) -> None:
    scene = default_scene()
    settings = ao.Settings(method=ao.Alchemy(radius=0.7))
    frames = []
    with ao.Renderer() as renderer:
        started = time.perf_counter()
        for turn in np.linspace(-0.35, 0.35, FRAMES // 2):  # radians; to and fro, since the walls are behind
            eye = 8.6 * np.array([np.sin(0.7 + turn), 0.5, np.cos(0.7 + turn)])
            camera = ao.Camera.perspective(0.6, 1.0, 30.0, ao.look_at(eye, (-0.2, 0.5, -0.3)))
            frames.append(renderer.render(scene, camera, size, settings, aovs=("image",)))
        spent = (time.perf_counter() - started) / len(frames)
        print(f"{1e3 * spent:.0f} ms a frame on {renderer.ctx.renderer}")
    save_animation(folder / "07_turntable.webp", [*frames, *frames[::-1]])
    frames[0].save(folder / "07_turntable.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
