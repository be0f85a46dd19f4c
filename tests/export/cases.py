"""What is drawn by several runtimes: depth, normals and colour of a little scene, by any projection."""

from __future__ import annotations

import base64
import dataclasses
from dataclasses import dataclass

import moderngl
import numpy as np

import ssao_gl as ao
from ssao_gl.gl.context import Context
from ssao_gl.scene.lens import Perspective

from ..render.test_effect import depth_texture, pixels, window_depth

SIZE = (160, 90)


def _reversed_infinite() -> ao.Camera:
    m = Perspective(0.9, 0.5).matrix(SIZE)
    m[2] = (0, 0, 0, 0.5)
    return ao.Camera.from_matrix(m, clip="0..1")


CAMERAS = {
    "perspective": ao.Camera.perspective(0.9, 0.5, 50.0),
    "off-centre": ao.Camera.pinhole(150, 140, 60, 50, SIZE, znear=0.5, zfar=50.0),
    "reversed infinite": _reversed_infinite(),
    "orthographic": ao.Camera.orthographic(4.0, 0.5, 20.0),
}


def settings(method: str, preset_name: str = "") -> ao.Settings:
    made = ao.method(method, preset_name)
    return ao.Settings(method=made if made.radius is not None else dataclasses.replace(made, radius=1.0))


@dataclass(frozen=True)
class Case:
    """What is given. row 0 of arrays on top."""

    camera: str
    size: tuple[int, int] = SIZE
    depth_kind: str = "window"
    normals: bool = False
    color: bool = False

    @property
    def eye(self) -> np.ndarray:
        """(h, w) scene units: balls before a slanted wall with a step, background on the right."""
        w, h = self.size
        x, y = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
        wall = 5.5 + x - np.where(y > 0.7, 0.6, 0.0)
        balls = [np.sqrt(np.maximum(0, 0.03 - (x - cx) ** 2 - (0.6 * (y - cy)) ** 2)) for cx, cy in ((0.25, 0.4), (0.6, 0.5))]
        return np.where(x > 0.9, 0.0, wall - 6 * np.maximum(*balls))

    @property
    def depth(self) -> np.ndarray:
        return window_depth(CAMERAS[self.camera], self.eye) if self.depth_kind == "window" else self.eye

    @property
    def normal(self) -> np.ndarray:
        """(h, w, 4) float64: those that points in rows and columns show, in view space."""
        points = CAMERAS[self.camera].view(self.size).points(self.eye)
        n = np.cross(np.gradient(points, axis=1), -np.gradient(points, axis=0))
        n /= np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-9)
        return np.concatenate([n, np.zeros((*n.shape[:2], 1))], -1)

    @property
    def picture(self) -> np.ndarray:
        """(h, w, 4) uint8 sRGB."""
        w, h = self.size
        rgba = np.zeros((h, w, 4), np.uint8)
        rgba[..., 0], rgba[..., 1], rgba[..., 2], rgba[..., 3] = 230, np.linspace(60, 255, w), 200, 255
        return rgba

    def job(self) -> dict:
        """Return it as the page takes it."""
        lens = CAMERAS[self.camera].lens
        projection = CAMERAS[self.camera].view(self.size).projection
        if getattr(lens, "clip", "") == "0..1":
            projection = lens.values
        return {
            "size": list(self.size),
            "window": self.depth_kind == "window",
            "depth": _text(self.depth.astype("<f4")),
            "normals": _text(self.normal.astype("<f4")) if self.normals else None,
            "color": _text(self.picture) if self.color else None,
            "projection": np.asarray(projection, float).T.ravel().tolist(),
            "clip": getattr(lens, "clip", "-1..1"),
        }


def _text(rows: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(rows[::-1]).tobytes()).decode()


def by_effect(ctx: Context, effect: ao.Effect, case: Case) -> np.ndarray:
    """(h, w, 4) uint8: what Python draws, of visibility only the first channel says something."""
    mgl = ctx.mgl
    made: list[moderngl.Texture] = []

    def texture(rows: np.ndarray, dtype: str) -> moderngl.Texture:
        data = np.ascontiguousarray(rows[::-1]).tobytes()
        made.append(mgl.texture(case.size, 1 if rows.ndim == 2 else 4, data, dtype=dtype, alignment=1))
        return made[-1]

    depth = depth_texture(ctx, case.depth) if case.depth_kind == "window" else texture(case.depth.astype("f4"), "f4")
    drawn = effect.apply(
        depth=depth,
        camera=CAMERAS[case.camera],
        depth_kind=case.depth_kind,
        normal=texture(case.normal.astype("f4"), "f4") if case.normals else None,
        color=texture(case.picture, "f1") if case.color else None,
    )
    found = pixels(ctx, drawn).copy()
    for one in made:
        one.release()
    return found


def references(chosen: ao.Settings, cases: list[Case]) -> tuple[str, list[np.ndarray]]:
    """Return the renderer's name and what Python draws of cases of one size, by ANGLE."""
    with ao.gl.open("angle") as ctx, ao.Effect(ctx, cases[0].size, chosen) as effect:
        return ctx.renderer, [by_effect(ctx, effect, case) for case in cases]
