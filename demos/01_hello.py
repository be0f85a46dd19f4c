"""Hello: draw a scene with ambient occlusion, headless, and look at what the picture holds."""

import argparse
from pathlib import Path

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene


def main(folder: Path, size: tuple[int, int]) -> None:
    # A path to a .glb, .obj, .ply or .stl file, a trimesh or a pyrender scene would do as well.
    scene = default_scene()
    picture = ao.render(scene, size=size, aovs=("image", "visibility", "depth", "normal"))

    # Arrays, row 0 on top. Visibility: 1 = open to the sky, 0 = closed in; background is exactly 1.
    seen = picture.visibility[picture.depth > 0]
    print(f"visibility {picture.visibility.shape} {picture.visibility.dtype}, mean on the scene {seen.mean():.2f}")
    print(f"method {picture.report['settings']['method']}, drawn by {picture.report['renderer']}")

    picture.save(folder / "01_hello.png")
    picture.save(folder / "01_visibility.png", aov="visibility")

    # Every part is a setting. This is the lecture's shader without a blur: four taps and their noise.
    lecture = ao.render(scene, size=size, method=ao.Lecture(samples=4), blur=None)
    lecture.save(folder / "01_lecture.png", aov="visibility")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
