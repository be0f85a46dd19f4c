"""The executor: plans from JSON, histories, additive blending, integers, shared targets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import ContextError
from ssao_gl.gl import open as open_context
from ssao_gl.gl.executor import FrameExecutor, SceneView
from ssao_gl.gl.frame_cache import FrameCache
from ssao_gl.gl.programs import GpuResources
from ssao_gl.gl.scene_buffers import SceneBuffers
from ssao_gl.graph.declare import PREVIOUS, Pass, Texture
from ssao_gl.graph.draws import Fullscreen, ViewValue
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.plan import Plan
from ssao_gl.graph.plan_json import plan_from_json, plan_to_json
from ssao_gl.graph.regions import DrawRegion
from ssao_gl.methods.registry import general
from ssao_gl.pipeline.frame_setup import frame_setup

from .. import shapes

SIZE = (48, 32)
CAMERA = shapes.camera()
VIEW = CAMERA.view(SIZE)
HERE = f"{__name__.rpartition('.')[0]}.shaders"


@pytest.fixture(scope="module")
def resources(provider: str) -> Iterator[GpuResources]:
    ctx = open_context(provider)
    made = GpuResources(ctx)
    yield made
    made.release()
    ctx.release()


def drawn(resources: GpuResources, plan: Plan, frames: int = 1) -> list[np.ndarray]:
    executor = FrameExecutor(resources, plan)
    try:
        return [executor.run(VIEW).read(plan.outputs[0]) for _ in range(frames)]
    finally:
        executor.release()


def shader(name: str) -> str:
    return f"{HERE}:{name}.frag"


COUNT = Pass(
    "count",
    "prepare",
    Fullscreen(shader("count"), {"u_before": f"frames{PREVIOUS}"}),
    {"frames": Texture("r32f", lifetime="history")},
)


def test_a_pass_counts_frames_by_its_own_history(resources: GpuResources) -> None:
    """Zeros before the first frame; the last frame's content in every later one; another executor begins anew."""
    plan = compile([COUNT], SIZE, ["frames"])
    assert [np.unique(image).tolist() for image in drawn(resources, plan, 5)] == [[1.0], [2.0], [3.0], [4.0], [5.0]]
    assert np.unique(drawn(resources, plan)[0]).tolist() == [1.0]


def test_a_history_is_read_by_others_as_it_was(resources: GpuResources) -> None:
    copy = Pass("copy", "prepare", Fullscreen(shader("count"), {"u_before": f"frames{PREVIOUS}"}), {"copy": Texture("r32f")})
    plan = compile([copy, COUNT], SIZE, ["copy"])
    assert [image.max() for image in drawn(resources, plan, 3)] == [1.0, 2.0, 3.0]


def test_additive_blending_sums_up(resources: GpuResources) -> None:
    """Over what another pass left: 1 and then 0.25 more."""
    first = Pass("first", "prepare", Fullscreen(shader("fill"), uniforms={"u_value": 1.0}), {"a": Texture("rgba16f")})
    more = Fullscreen(shader("fill"), uniforms={"u_value": 0.25})
    second = Pass("second", "prepare", more, {"b": Texture("rgba16f")}, over={"b": "a"}, blend="add")
    assert np.unique(drawn(resources, compile([first, second], SIZE, ["b"]))[0]).tolist() == [1.25]


def test_beside_the_region_a_pass_leaves_what_it_says(resources: GpuResources) -> None:
    """There it draws nothing, of a full target or a smaller one."""
    for scale in (1, 2):
        draw = Fullscreen(shader("fill"), uniforms={"u_value": 1.0})
        plan = compile([Pass("fill", "prepare", draw, {"a": Texture("rgba16f", 1 / scale)}, clear=(0.25,) * 4)], SIZE, ["a"])
        executor = FrameExecutor(resources, plan)
        found = executor.run(VIEW, region=DrawRegion(scene_rect=(8, 4, 16, 12))).read("a")[..., 0]
        expected = np.full_like(found, 0.25)
        expected[4 // scale : 16 // scale, 8 // scale : 24 // scale] = 1
        assert np.array_equal(found, expected)
        executor.release()


def test_integers_are_drawn_and_read(resources: GpuResources) -> None:
    draw = Fullscreen(shader("integers"), uniforms={"u_size": ViewValue("target_size")}, defines={"TARGETS": 1})
    plan = compile([Pass("integers", "prepare", draw, {"n": Texture("r32ui")})], SIZE, ["n"])
    w, h = SIZE
    expected = np.arange(w * h, dtype=np.uint32).reshape(h, w) + 0xFFFF0000
    assert np.array_equal(drawn(resources, plan)[0][..., 0], expected)


def test_a_3d_target_is_refused_in_words(resources: GpuResources) -> None:
    draw = Fullscreen(shader("fill"), uniforms={"u_value": 1.0})
    plan = compile([Pass("fill", "prepare", draw, {"a": Texture("rgba16f", depth=4)})], SIZE, ["a"])
    with pytest.raises(ContextError, match="3-D textures can be read, but not yet be drawn into"):
        FrameExecutor(resources, plan)


@pytest.mark.parametrize("method", [name for name in general() if "prepared" not in ao.method(name).traits.inputs])
@pytest.mark.parametrize("blur", [None, ao.Joint(), ao.Separable(), ao.LectureBlur()], ids=lambda b: b.name if b else "none")
def test_a_plan_from_json_draws_the_same_bytes(resources: GpuResources, method: str, blur: object) -> None:
    settings = ao.Settings(method=ao.method(method), blur=blur)  # type: ignore[arg-type]
    scene = shapes.corner()
    made = frame_setup(scene, CAMERA, SIZE, settings, 1024)
    plan = made.plan(("image", "visibility"))
    again = plan_from_json(plan_to_json(plan))
    assert again == plan and again.layout == plan.layout
    buffers = SceneBuffers(resources, scene)
    images = []
    for one in (plan, again):
        executor = FrameExecutor(resources, one)
        frame = executor.run(made.view, scene=SceneView(buffers, CAMERA), region=made.region, checked=True)
        images.append(frame.read("image"))
        executor.release()
    buffers.release()
    assert np.array_equal(*images) and images[0].std() > 1


def test_plans_of_one_layout_share_targets_and_keep_their_own_draws(resources: GpuResources) -> None:
    cache: FrameCache[float] = FrameCache(resources)

    def plan(value: float) -> Plan:
        draw = Fullscreen(shader("fill"), uniforms={"u_value": value})
        return compile([Pass("fill", "prepare", draw, {"a": Texture("rgba16f")})], SIZE, ["a"])

    one, two = (cache.get(value, lambda value=value: plan(value)) for value in (0.5, 2.0))  # type: ignore[misc]
    assert one.targets is two.targets and cache.get(0.5, lambda: plan(9.0)) is one
    assert [executor.run(VIEW).read("a").max() for executor in (one, two, one)] == [0.5, 2.0, 0.5]
    cache.clear()


def test_a_scene_pass_without_a_scene_says_so(resources: GpuResources) -> None:
    made = frame_setup(shapes.corner(), CAMERA, SIZE, ao.Settings(), 1024)
    executor = FrameExecutor(resources, made.plan(("depth",)))
    with pytest.raises(ContextError, match="'gbuffer' draws a scene, and this frame has none"):
        executor.run(made.view)
    executor.release()


def test_settings_of_one_layout_do_not_mix(provider: str) -> None:
    """Pictures that take turns on one renderer are those that each gets alone."""
    scene, every = (
        shapes.corner(),
        [ao.Settings(method=ao.Bitmask(radius=r)) for r in (0.3, 0.6, 1.0, 2.0)],
    )
    alone = []
    for settings in every:
        with ao.Renderer(provider) as renderer:
            alone.append(renderer.render(scene, CAMERA, SIZE, settings).image)
    with ao.Renderer(provider) as renderer:
        for _ in range(2):
            for settings, image in zip(every, alone, strict=True):
                assert np.array_equal(renderer.render(scene, CAMERA, SIZE, settings).image, image)
    assert len({image.tobytes() for image in alone}) == 4
