"""Open3D: its meshes drawn by ssao_gl, and an RGB-D image dimmed."""

import argparse
from pathlib import Path

import numpy as np

import ssao_gl as ao


def blocks(o3d):
    """A mesh with vertex colours: boxes on a floor, and a ring."""
    made = o3d.geometry.TriangleMesh.create_box(6, 0.2, 6).translate((-3, -0.2, -3)).paint_uniform_color((0.75, 0.72, 0.66))
    for number in range(9):
        i, j = divmod(number, 3)
        height = 0.6 + 0.5 * ((5 * number) % 4)
        box = o3d.geometry.TriangleMesh.create_box(1, height, 1).translate((1.5 * i - 2, 0, 1.5 * j - 2))
        made += box.paint_uniform_color((0.35 + 0.06 * number, 0.5, 0.8 - 0.05 * number))
    ring = o3d.geometry.TriangleMesh.create_torus(1.0, 0.25)
    return made + ring.translate((0, 2.6, 0)).paint_uniform_color((0.8, 0.35, 0.2))


def main(folder: Path, size: tuple[int, int]) -> None:
    try:
        import open3d as o3d
    except (ImportError, OSError) as reason:
        return print(f"skipped: open3d cannot be imported here ({reason})")
    mesh, method = blocks(o3d), ao.Bitmask(radius=0.6)
    eye, target, up = (6.5, 5.5, 7.5), (0, 0.6, 0), (0, 1, 0)
    w, h = size
    intrinsic = o3d.camera.PinholeCameraIntrinsic(w, h, 0.9 * w, 0.9 * w, w / 2, h / 2)

    # A mesh or point cloud, legacy or tensor, and a camera by Open3D's intrinsics and a pose.
    drawn = ao.render(mesh, (intrinsic, ao.look_at(eye, target, up)), size, method=method, aovs=("image", "depth"))
    drawn.save(folder / "11_open3d.png")

    # An RGB-D image as a depth camera gives it: uint8 colour, uint16 millimetres. Open3D's own makes metres of them.
    color, millimetres = drawn.image, np.round(1000 * drawn.depth).astype(np.uint16)
    rgbd = o3d.geometry.RGBDImage.create_from_color_and_depth(
        o3d.geometry.Image(color), o3d.geometry.Image(millimetres), depth_trunc=60, convert_rgb_to_intensity=False
    )
    ao.apply(rgbd.color, rgbd.depth, intrinsic, method=method).save(folder / "11_rgbd.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
