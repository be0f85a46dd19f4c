"""Molecule: draw a PDB or mmCIF file, or spheres from arrays, with ambient occlusion."""

import argparse
from pathlib import Path

import numpy as np

import ssao_gl as ao


def helix(turns: int = 6) -> ao.Scene:
    """Something like a molecule, for want of a file: two strands of balls and the rungs between them."""
    angle = np.linspace(0, 2 * np.pi * turns, 40 * turns)
    strands = [np.stack([9 * np.cos(angle + a), 3.4 * turns / np.pi * angle / 2, 9 * np.sin(angle + a)], -1) for a in (0, 2.4)]
    rungs = [(1 - share) * strands[0][::4] + share * strands[1][::4] for share in np.linspace(0.15, 0.85, 7)]
    colors = [(230, 120, 70), (80, 140, 220), *[(200, 200, 190)] * 7]
    spheres = [
        ao.Spheres.from_points(points, 1.8, np.tile(np.uint8([*color, 255]), (len(points), 1)))
        for points, color in zip([*strands, *rungs], colors, strict=True)
    ]
    return ao.Scene(spheres=spheres)


def main(folder: Path, size: tuple[int, int], file: Path | None, assembly: str | None) -> None:
    # An assembly is drawn as copies: a capsid of a million atoms takes no more memory than the atoms of the file.
    scene = helix() if file is None else ao.load_scene(file, molecule=ao.MoleculeOptions(assembly=assembly, color="chain"))
    print(f"{scene.name or 'a helix'}: {scene.contents}")
    radius = scene.default_radius(0.08)
    with ao.Renderer() as renderer:
        picture = renderer.render(
            scene, size=size, settings=ao.Settings(method=ao.Bitmask(radius=radius)), aovs=("image", "visibility")
        )
    picture.save(folder / "08_molecule.png", aov="image")
    picture.save(folder / "08_visibility.png", aov="visibility")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path, help="PDB or mmCIF file (default: a helix of spheres)")
    parser.add_argument("--assembly", metavar="NAME", help="biological assembly of the file, as 1")
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height), arguments.file, arguments.assembly)
