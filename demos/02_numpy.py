"""Arrays in, arrays out: a depth image with OpenCV intrinsics, as a depth camera, a simulator or a neural network gives it."""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import ssao_gl as ao


def measure(k: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) metres along the view axis to balls on a table, 0 where nothing is, and (h, w, 3) uint8 sRGB.

    In the axes of OpenCV: x right, y down, z forward.
    """
    u, v = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    ray = np.stack([(u - k[0, 2]) / k[0, 0], (v - k[1, 2]) / k[1, 1], np.ones_like(u)], -1)  # point = depth * ray
    up = np.array([0.0, -0.8, -0.6])  # the camera looks down on the table
    with np.errstate(all="ignore"):
        table = -0.8 / (ray @ up)
        depth = np.where((table > 0) & (table < 1.9), table, np.inf)
        color = np.where(np.isfinite(depth)[..., None], np.uint8([214, 196, 172]), np.uint8([150, 170, 200]))
        for x, z, radius, paint in ((-0.12, 1.35, 0.2, (200, 120, 95)), (0.16, 1.2, 0.1, (110, 150, 190))):
            middle = np.array([x, (0.8 - radius - 0.6 * z) / 0.8, z])  # so high that it lies on the table
            a, b, c = (ray**2).sum(-1), ray @ middle, middle @ middle - radius**2
            hit = (b - np.sqrt(b * b - a * c)) / a
            color = np.where((hit < depth)[..., None], np.uint8(paint), color)
            depth = np.fmin(depth, hit)
    return np.where(np.isfinite(depth), depth, 0).astype(np.float32), color


def main(folder: Path, size: tuple[int, int]) -> None:
    w, h = size
    k = np.array([[0.8 * w, 0, 0.5 * w], [0, 0.8 * w, 0.62 * h], [0, 0, 1]])  # fx, fy, cx, cy in pixels
    depth, color = measure(k, size)
    camera = ao.Camera.pinhole(k[0, 0], k[1, 1], k[0, 2], k[1, 2], size)

    # Visibility alone; the radius is in the unit of the depth. Normals are rebuilt from depth.
    visibility = ao.occlusion(depth, camera, method=ao.Alchemy(radius=0.15))

    # Or dim a picture that you have, uint8 sRGB, in linear light.
    picture = ao.apply(color, depth, camera, method=ao.Alchemy(radius=0.15))

    Image.fromarray((visibility * 255).round().astype(np.uint8)).save(folder / "02_visibility.png")
    picture.save(folder / "02_numpy.png")
    np.save(folder / "02_visibility.npy", visibility)
    print(f"visibility {visibility.min():.2f} to {visibility.max():.2f}, background {visibility[depth == 0].min():g}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
