"""pyrender, three ways: ssao_gl draws a pyrender.Scene, stands in for its OffscreenRenderer, or dims what that drew."""

import argparse
import os
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

import ssao_gl as ao

os.environ.setdefault("PYOPENGL_PLATFORM", "egl")  # pyrender's own OpenGL, headless; ssao_gl needs no such thing


def build(pyrender):
    scene = pyrender.Scene(bg_color=[1.0, 1.0, 1.0], ambient_light=[0.35, 0.35, 0.35], name="blocks")
    stone = pyrender.MetallicRoughnessMaterial(baseColorFactor=[0.7, 0.66, 0.6, 1], metallicFactor=0, roughnessFactor=1)
    clay = pyrender.MetallicRoughnessMaterial(baseColorFactor=[0.75, 0.3, 0.18, 1], metallicFactor=0, roughnessFactor=1)
    poses = np.tile(np.eye(4), (25, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = (1.15 * (np.indices((5, 5)).reshape(2, 25) - 2)).tolist()
    poses[:, 1, 3] = 0.5 + 0.3 * np.sin(np.arange(25) * 2.4)
    block = trimesh.creation.box((1, 1, 1))
    scene.add(pyrender.Mesh.from_trimesh(block, material=stone, poses=poses, smooth=False))
    scene.add(pyrender.Mesh.from_trimesh(trimesh.creation.box((7, 0.2, 7)), material=stone, smooth=False))
    ball = pyrender.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=4, radius=0.8), material=clay)
    scene.add(ball, pose=trimesh.transformations.translation_matrix((0.55, 1.9, 0.55)))
    pose = ao.look_at(eye=(6, 7, 9.5), target=(0, 0.3, 0.2))
    scene.add(pyrender.PerspectiveCamera(yfov=0.7, znear=0.1, zfar=40), pose=pose)
    scene.add(pyrender.DirectionalLight(intensity=3), pose=pose)
    return scene


def main(folder: Path, size: tuple[int, int]) -> None:
    try:
        import pyrender
    except (ImportError, AttributeError) as reason:  # it loads an OpenGL library at once
        return print(f"skipped: pyrender cannot be imported here ({reason})")
    scene = build(pyrender)
    ao.render(scene, size=size, method=ao.Alchemy(radius=0.6)).save(folder / "04_direct.png")

    # A script that uses pyrender's OffscreenRenderer keeps all its calls; this one is drawn by ssao_gl.
    with ao.OffscreenRenderer(*size, settings=ao.Settings(method=ao.Alchemy(radius=0.6))) as stand_in:
        color, depth = stand_in.render(scene, pyrender.RenderFlags.RGBA)
        segments, _ = stand_in.render(
            scene, pyrender.RenderFlags.SEG, {node: 60 + 60 * i for i, node in enumerate(scene.mesh_nodes)}
        )
    Image.fromarray(color).save(folder / "04_stand_in.png")
    Image.fromarray(segments).save(folder / "04_segments.png")
    try:
        renderer = pyrender.OffscreenRenderer(*size)
        color, depth = renderer.render(scene)
    except Exception as reason:  # whatever PyOpenGL and the driver come up with
        return print(f"OffscreenRenderer skipped: pyrender's own OpenGL does not start here ({reason})")
    Image.fromarray(color).save(folder / "04_pyrender_alone.png")
    color = ao.apply(color, depth, camera=scene, method=ao.Alchemy(radius=0.6)).image  # the one line to add
    Image.fromarray(color).save(folder / "04_pyrender.png")
    renderer.delete()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    main(arguments.o, tuple(map(int, arguments.size.split("x"))))
