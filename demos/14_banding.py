"""Banding and noise: the same few taps in one pattern for all pixels, in another one for each, and filtered; with numbers."""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene

FEW = {"slices": 1, "steps": 3, "scale": 1}
WAYS = {
    "one pattern": (ao.Bitmask(tile=1, **FEW), None),
    "a pattern a pixel": (ao.Bitmask(tile=4, **FEW), None),
    "filtered": (ao.Bitmask(tile=4, **FEW), ao.Joint()),
}
CONVERGED = ao.Bitmask(tile=4, slices=16, steps=48, scale=1)
BOX = 4
"""Pixels over which noise averages out, and banding does not."""


def means(error: np.ndarray) -> np.ndarray:
    """Return the mean over the box around each pixel, by sums of rows and columns."""
    sums = np.pad(error, ((1, 0), (1, 0))).cumsum(0).cumsum(1)
    return (sums[BOX:, BOX:] - sums[:-BOX, BOX:] - sums[BOX:, :-BOX] + sums[:-BOX, :-BOX]) / BOX**2


def main(folder: Path, size: tuple[int, int]) -> None:
    scene, panel = default_scene(), (max(size[0] // len(WAYS), 1), size[1])
    sheet = Image.new("L", size, 255)
    with ao.Renderer() as renderer:

        def visibility(method: ao.Bitmask, blur: ao.Joint | None) -> np.ndarray:
            return renderer.render(scene, None, panel, ao.Settings(method=method, blur=blur), aovs="visibility").visibility

        truth = visibility(CONVERGED, None)
        print(
            f"{'':18} banding   noise   (sigma of what is off the same method with many taps: by boxes of {BOX} pixels, and within them)"
        )
        for place, (name, (method, blur)) in enumerate(WAYS.items()):
            found = visibility(method, blur)
            error = found - truth
            smooth = means(error)
            inner = error[BOX // 2 : BOX // 2 + smooth.shape[0], BOX // 2 : BOX // 2 + smooth.shape[1]]
            print(f"{name:18} {smooth.std():.4f}   {(inner - smooth).std():.4f}")
            sheet.paste(Image.fromarray(np.uint8(np.round(255 * found))), (place * panel[0], 0))
    sheet.save(folder / "14_banding.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the picture (default: here)")
    parser.add_argument("--size", metavar="WxH", default="1200x360", help="pixels (default: 1200x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
