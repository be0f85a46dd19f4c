"""A stream of RGB-D frames, as from a RealSense or Kinect: uint16 millimetres with noise, one Renderer for all of them."""

import argparse
import time
from pathlib import Path

import numpy as np

import ssao_gl as ao

FRAMES = 50


def camera_frames(size: tuple[int, int], count: int):
    """Yield (h, w, 3) uint8 colour and (h, w) uint16 millimetres: balls that roll over a table, 0 where nothing was measured."""
    w, h = size
    noise = np.random.default_rng(3)
    u, v = np.meshgrid((np.arange(w) + 0.5 - w / 2) / (0.8 * w), (np.arange(h) + 0.5 - h / 2) / (0.8 * w))
    ray = np.stack([u, v, np.ones_like(u)], -1)  # in the axes of OpenCV: point = depth * ray
    up = np.array([0.0, -0.8, -0.6])
    for turn in np.linspace(0, 2 * np.pi, count, endpoint=False):
        with np.errstate(all="ignore"):
            z = np.where(ray @ up < 0, -0.8 / (ray @ up), np.inf)
            color = np.where((z < 3)[..., None], np.uint8([214, 196, 172]), np.uint8([150, 170, 200]))
            for k, paint in enumerate(((200, 120, 95), (110, 150, 190), (150, 180, 110))):
                x, far, radius = 0.32 * np.cos(turn + 2.1 * k), 1.35 + 0.25 * np.sin(turn + 2.1 * k), 0.12
                middle = np.array([x, (0.8 - radius - 0.6 * far) / 0.8, far])
                a, b, c = (ray**2).sum(-1), ray @ middle, middle @ middle - radius**2
                hit = (b - np.sqrt(b * b - a * c)) / a
                color = np.where((hit < z)[..., None], np.uint8(paint), color)
                z = np.fmin(z, hit)
        z = z + 0.0014 * np.where(z < 3, z, 0) ** 2 * noise.standard_normal(z.shape)
        yield color, np.where(z < 3, np.round(1000 * z), 0).astype(np.uint16)


def main(folder: Path, size: tuple[int, int]) -> None:
    w, h = size
    camera = ao.Camera.pinhole(0.8 * w, 0.8 * w, w / 2, h / 2, size)
    settings = ao.Settings(method=ao.method("bitmask", "draft", radius=0.15))
    frames = list(camera_frames(size, FRAMES))
    with ao.Renderer() as renderer:

        def shaded(color, millimetres):
            depth = ao.DepthImage(millimetres, scale=0.001, empty="accept")
            return renderer.apply(depth, camera, color=color, settings=settings, aovs="visibility")

        shaded(*frames[0])  # the first one compiles the shaders
        wall, cpu = time.perf_counter(), time.process_time()
        pictures = [shaded(*frame) for frame in frames]
        wall, cpu = (time.perf_counter() - wall) / FRAMES, (time.process_time() - cpu) / FRAMES
    print(f"{w}x{h}: {1 / wall:.0f} frames/s, {1e3 * wall:.1f} ms wall, {1e3 * cpu:.1f} ms CPU a frame")
    pictures[0].save(folder / "12_stream.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="320x240", help="pixels (default: 320x240)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
