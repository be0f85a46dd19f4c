"""A volume from numpy: its iso-surface, and the same voxels under a transfer function, both with ambient occlusion.

CT and MRI data come the same way: `ao.load_scene("head.nii.gz")`, or `ssao-gl render tooth.nhdr --iso 600`.
"""

import argparse
from pathlib import Path

import numpy as np

import ssao_gl as ao


def gyroid(n: int = 96) -> tuple[np.ndarray, np.ndarray]:
    """Voxels (x, y, z) of a gyroid's wall inside a ball of radius 1, 1 in its middle and 0 outside; and their affine."""
    h = 2.2 / (n - 1)
    affine = np.diag([h, h, h, 1.0])
    affine[:3, 3] = -1.1
    x, y, z = np.meshgrid(*[np.linspace(-1.1, 1.1, n)] * 3, indexing="ij")
    a, b, c = 7 * x, 7 * y, 7 * z
    wall = 1 - np.abs(np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a))
    inside = np.clip((1 - np.sqrt(x**2 + y**2 + z**2)) / (2 * h) + 0.5, 0, 1)
    return (wall * inside).astype(np.float32), affine


def main(folder: Path, size: tuple[int, int]) -> None:
    voxels, affine = gyroid()
    glass = ao.Transfer(
        [
            ao.TransferPoint(0.35, 0.0, (0.15, 0.35, 0.75)),
            ao.TransferPoint(0.55, 0.35, (0.35, 0.65, 0.9)),
            ao.TransferPoint(1.0, 0.9, (1.0, 0.95, 0.85)),
        ]
    )
    surface = ao.Volume(voxels, affine, iso=0.5, color=(0.85, 0.8, 0.7))
    seen_through = ao.Volume(voxels, affine, transfer=glass)
    camera = ao.Camera.perspective(0.62, 0.5, 20.0, ao.look_at((2.6, 1.9, 2.6), (0, 0, 0)))
    settings = ao.Settings(method=ao.Bitmask(radius=0.3))
    with ao.Renderer() as renderer:
        for name, volume in (("surface", surface), ("transfer", seen_through)):
            picture = renderer.render(ao.as_scene(volume), camera, size, settings, aovs=("image",))
            picture.save(folder / f"09_volume_{name}.png")
            print(f"09_volume_{name}.png: {ao.as_scene(volume).contents}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
