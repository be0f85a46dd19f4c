"""trimesh: meshes of your own in a scene graph, many of them instances that share one geometry."""

import argparse
from pathlib import Path

import numpy as np
import trimesh
from trimesh.transformations import rotation_matrix, translation_matrix

import ssao_gl as ao


def marbles_in_a_tray() -> trimesh.Scene:
    scene = trimesh.Scene()
    wood, glass = [176, 137, 104, 255], [120, 160, 200, 255]
    for number, (extents, at) in enumerate(
        (((7, 7, 0.2), (0, 0, -0.1)), ((7, 0.2, 1), (0, 3.4, 0.5)), ((7, 0.2, 1), (0, -3.4, 0.5)), ((0.2, 7, 1), (3.4, 0, 0.5)))
    ):
        wall = trimesh.creation.box(extents)
        wall.visual.vertex_colors = wood
        scene.add_geometry(wall, node_name=f"tray {number}", transform=translation_matrix(at))

    # One sphere, placed 49 times: it is uploaded once and drawn in one call.
    marble = trimesh.creation.icosphere(subdivisions=4, radius=0.42)
    marble.visual.vertex_colors = glass
    scene.add_geometry(marble, geom_name="marble", node_name="marble", transform=translation_matrix((-2.8, -2.8, 0.42)))
    jitter = np.random.default_rng(1).uniform(-0.12, 0.12, (7, 7, 2))
    for i, j in np.ndindex(7, 7):
        if (i, j) != (0, 0):
            x, y = np.array([0.93 * i - 2.8, 0.93 * j - 2.8]) + jitter[i, j] * 0.5
            scene.graph.update(f"marble {i} {j}", geometry="marble", matrix=translation_matrix((x, y, 0.42)))

    ring = trimesh.creation.torus(0.9, 0.22)
    ring.visual.vertex_colors = [205, 120, 90, 255]
    scene.add_geometry(ring, transform=translation_matrix((0.3, -0.2, 1.1)) @ rotation_matrix(0.35, (1, 0.3, 0)))
    return scene


def main(folder: Path, size: tuple[int, int]) -> None:
    pose = ao.look_at(eye=(-8, -9.5, 9), target=(0, 0, -0.2), up=(0, 0, 1))
    camera = ao.Camera.perspective(yfov=0.6, znear=0.1, zfar=50, pose=pose)
    picture = ao.render(marbles_in_a_tray(), camera, size, method=ao.Alchemy(radius=0.6))
    picture.save(folder / "03_trimesh.png")
    picture.save(folder / "03_visibility.png", aov="visibility")
    print(f"{picture.report['triangles']:,} triangles in {1e3 * picture.report['seconds']:.0f} ms")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
