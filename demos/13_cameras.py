"""Cameras and depth of reconstructions: COLMAP's and NeRF's camera files, and the raw depth of nerfstudio's ``ns-render``."""

import argparse
import gzip
import json
from pathlib import Path

import numpy as np

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene


def write_files(folder: Path, size: tuple[int, int], pose: np.ndarray) -> None:
    """Write what COLMAP and nerfstudio would leave of one view. ``pose``: camera-to-world, OpenGL axes."""
    w, h = size
    focal = 1.1 * w
    world_to_camera = np.diag([1.0, -1.0, -1.0, 1.0]) @ np.linalg.inv(pose)  # OpenCV's axes: y down, z forward
    x, y, z, qw = quaternion(world_to_camera[:3, :3])
    tx, ty, tz = world_to_camera[:3, 3]
    (folder / "cameras.txt").write_text(f"1 PINHOLE {w} {h} {focal} {focal} {w / 2} {h / 2}\n")
    (folder / "images.txt").write_text(f"1 {qw} {x} {y} {z} {tx} {ty} {tz} 1 view.png\n\n")
    lens = {"fl_x": focal, "fl_y": focal, "cx": w / 2, "cy": h / 2, "w": w, "h": h}
    frames = [{"file_path": "view.png", "transform_matrix": pose.tolist()}]
    (folder / "transforms.json").write_text(json.dumps({**lens, "frames": frames}))


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """(x, y, z, w) of a rotation (3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat()


def main(folder: Path, size: tuple[int, int]) -> None:
    files = folder / "files"
    files.mkdir(exist_ok=True)
    write_files(files, size, ao.look_at((5, 4, 6), (-0.2, 0.5, -0.3)))
    scene, method = default_scene(), ao.Bitmask(radius=0.7)

    # A camera file is a camera: a name behind the colon chooses one of its views.
    ao.render(scene, f"{files}/transforms.json:view.png", size, method=method).save(folder / "13_nerf.png")
    drawn = ao.render(scene, f"{files}/images.txt:view.png", size, method=method, aovs=("image", "color", "depth"))
    drawn.save(folder / "13_colmap.png")

    # nerfstudio's nerfacto renders depth along the ray, (h, w, 1), packed; splatfacto's lies along the view axis: kind "eye".
    rays = np.linalg.norm(np.stack([*np.meshgrid(*[(np.arange(n) + 0.5 - n / 2) / (1.1 * size[0]) for n in size]),
                                    np.ones(size[::-1])]), axis=0)  # fmt: skip
    with gzip.open(files / "depth.npy.gz", "wb") as file:
        np.save(file, (drawn.depth * rays)[..., None].astype(np.float32))
    shaded = ao.apply(drawn.color, files / "depth.npy.gz", f"{files}/transforms.json", depth_kind="ray", method=method)
    shaded.save(folder / "13_nerfstudio.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
