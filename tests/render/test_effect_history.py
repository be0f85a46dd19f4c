"""Effects over the frames of somebody else's program."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.gl.context import Context
from ssao_gl.io.images import flipped
from ssao_gl.scene.camera import Camera

from ..shapes import camera
from .test_effect import eye_depth, pixels

SIZE = (64, 48)
SETTINGS = ao.Settings(method=ao.Bitmask(radius=0.7, scale=1, slices=1, steps=2, guard=0.0), blur=None)


@pytest.fixture(scope="module")
def context(provider: str) -> Iterator[Context]:
    with ao.gl.open(provider) as ctx:
        yield ctx


class Program:
    """One that draws depth by somebody else's means, and asks an effect for visibility."""

    def __init__(self, ctx: Context, depth: np.ndarray) -> None:
        self.ctx = ctx
        self.depth = ctx.mgl.texture(SIZE, 1, flipped(depth).astype("f4").tobytes(), dtype="f4")
        self.effect = ao.Effect(ctx, SIZE, SETTINGS)

    def frame(self, cam: Camera, **given: bool) -> np.ndarray:
        texture = self.effect.apply(depth=self.depth, camera=cam, depth_kind="eye", **given)
        return pixels(self.ctx, texture)[..., 0].astype(int)


@pytest.fixture
def program(context: Context) -> Iterator[tuple[Program, Camera]]:
    cam = camera()
    made = Program(context, eye_depth(cam, SIZE))
    yield made, cam
    made.effect.release()
    made.depth.release()
    context.check_error("the test")


def test_calls_that_ask_for_it_are_averaged(program: tuple[Program, Camera]) -> None:
    """The mean of a camera that stands converges: the more frames, the less the next one changes; others stay as they were."""
    made, cam = program
    plain = made.frame(cam)
    found = [made.frame(cam, history=True) for _ in range(12)]
    assert (found[0] == plain).all() and (made.frame(cam) == plain).all()
    steps = [np.abs(b - a).mean() for a, b in pairwise(found)]
    assert steps[0] > 4 * steps[-1] > 0
    assert found[-1].std() < plain.std()


def test_a_cut_begins_anew_with_the_same_bytes(program: tuple[Program, Camera]) -> None:
    made, cam = program
    whole = [made.frame(cam, history=True) for _ in range(3)]
    made.effect.cut()
    assert all((made.frame(cam, history=True) == before).all() for before in whole)
    made.effect.settings = dataclasses.replace(SETTINGS)
    assert (made.frame(cam, history=True) == whole[0]).all()


def test_pose_says_where_things_were(program: tuple[Program, Camera]) -> None:
    """The same depth under a pose far away is another place: nothing of it is taken."""
    made, cam = program
    made.frame(cam, history=True)
    pose = np.array(cam.pose)
    pose[:3, 3] += 50.0
    found = made.frame(dataclasses.replace(cam, pose=pose), history=True)
    made.effect.cut()
    made.frame(dataclasses.replace(cam, pose=pose), history=True)
    again = made.frame(cam, history=True)
    assert (found == again).all()
