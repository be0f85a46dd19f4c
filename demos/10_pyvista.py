"""PyVista, three ways: a plotter drawn by ssao_gl, occlusion over what VTK drew, and a mesh alone. PyVista needs no window."""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import ssao_gl as ao


def build(pyvista, size: tuple[int, int]):
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    x, y = np.meshgrid(np.linspace(-4, 4, 161), np.linspace(-4, 4, 161))
    hills = pyvista.StructuredGrid(x, y, 0.45 * np.sin(2.2 * x) * np.cos(1.7 * y) - 0.08 * (x**2 + y**2))
    hills["height"] = hills.points[:, 2]
    plotter.add_mesh(hills, scalars="height", cmap="terrain", show_scalar_bar=False, smooth_shading=True)
    for angle in np.arange(0, 2 * np.pi, np.pi / 4):
        column = pyvista.Cylinder(
            center=(2 * np.cos(angle), 2 * np.sin(angle), 0.2), direction=(0, 0, 1), radius=0.25, height=2
        )
        plotter.add_mesh(column, color="ivory", smooth_shading=True, split_sharp_edges=True)
    plotter.add_mesh(pyvista.ParametricTorus(ringradius=2, crosssectionradius=0.3).translate((0, 0, 1.3)), color="tomato")
    plotter.set_background("#b8c4d0")
    plotter.camera_position = [(7.5, -8, 6.5), (0, 0, -0.2), (0, 0, 1)]
    return plotter


def main(folder: Path, size: tuple[int, int]) -> None:
    try:
        import pyvista
    except ImportError as reason:
        return print(f"skipped: pyvista cannot be imported here ({reason})")
    plotter = build(pyvista, size)

    # The plotter's meshes, colours, background and camera, drawn by ssao_gl.
    ao.render(plotter, size=size, method=ao.Bitmask(radius=0.8)).save(folder / "10_pyvista.png")

    # Or occlusion over the picture that VTK drew: its colour, its depth, its camera.
    color = plotter.screenshot(return_img=True)
    depth = plotter.get_image_depth()
    shaded = ao.apply(color, depth, plotter, depth_kind="vtk", method=ao.Bitmask(radius=0.8))
    Image.fromarray(color).save(folder / "10_vtk_alone.png")
    shaded.save(folder / "10_vtk_shaded.png")

    # Or a mesh, without any plotter.
    ao.render(pyvista.ParametricBoy().scale(2.0), size=size).save(folder / "10_mesh.png")
    plotter.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    main(arguments.o, (width, height))
