"""Elements: the light of a sky, with occlusion, and with the light that surfaces send each other, all baked into vertex colours.

After Bunnell, "Dynamic Ambient Occlusion and Indirect Lighting", GPU Gems 2 (2005). Needs numba: pip install 'ssao_gl[truth-spheres]'
"""

import argparse
from pathlib import Path

import numpy as np
import trimesh

import ssao_gl as ao

RED, GREEN, WHITE = (0.75, 0.12, 0.08), (0.12, 0.5, 0.12), (0.8, 0.78, 0.72)


def grid(corner: tuple[float, ...], u: tuple[float, ...], v: tuple[float, ...], n: int, color: tuple[float, ...]) -> ao.Mesh:
    """A parallelogram of 2 n^2 triangles, for light is kept at their vertices; its front is where u x v points to."""
    s, t = (part.ravel()[:, None] for part in np.meshgrid(*[np.linspace(0, 1, n + 1)] * 2))
    points = np.asarray(corner) + s * np.asarray(u) + t * np.asarray(v)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate([first[:, None] + (0, 1, n + 2), first[:, None] + (0, n + 2, n + 1)])
    pattern = 0.85 + 0.15 * np.cos(12 * np.pi * s) * np.cos(12 * np.pi * t)
    colors = np.column_stack([255 * pattern * color, np.full(len(s), 255)]).round().astype(np.uint8)
    return ao.Mesh(points.astype(np.float32), triangles.astype(np.uint32), color=(1, 1, 1), vertex_colors=colors)


def ball(at: tuple[float, ...], radius: float) -> ao.Mesh:
    made = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    points = np.asarray(made.vertices + at, np.float32)
    return ao.Mesh(points, np.asarray(made.faces, np.uint32), normals=np.asarray(made.vertex_normals, np.float32), color=WHITE)


def room() -> ao.Scene:
    """Two coloured walls, a floor and a back wall, open to the sky and to the front, with two balls."""
    return ao.Scene(
        [
            grid((-1, 0, 1), (2, 0, 0), (0, 0, -2), 24, WHITE),
            grid((-1, 0, -1), (2, 0, 0), (0, 1.4, 0), 24, WHITE),
            grid((-1, 0, 1), (0, 0, -2), (0, 1.4, 0), 24, RED),
            grid((1, 0, -1), (0, 0, 2), (0, 1.4, 0), 24, GREEN),
            ball((-0.5, 0.4, -0.2), 0.4),
            ball((0.5, 0.3, 0.15), 0.3),
        ]
    )


def main(folder: Path, size: tuple[int, int]) -> None:
    scene = room()
    camera = ao.Camera.perspective(0.6, 0.1, 20.0, ao.look_at((0, 1.3, 3.4), (0, 0.62, 0)))
    elements = {"by": "elements", "radius": 4.0, "passes": 3}
    stages = {"1_environment": scene}
    for name, more in (("2_occlusion", {}), ("3_indirect", {"indirect": True})):
        baked = ao.bake(scene, ao.Baking(**elements, **more))
        baked.save(folder / "baked.glb")
        stages[name] = ao.load_scene(folder / "baked.glb")
        (folder / "baked.glb").unlink()
        print(f"{name}: {baked.seconds:.1f} s")
    # All light is a sky's, and how much of it arrives stands in the colours: there is nothing to shade.
    with ao.Renderer() as renderer:
        for name, stage in stages.items():
            picture = renderer.render(stage, camera, size, aovs=("color",))
            picture.save(folder / f"15_elements_{name}.png", aov="color")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
