"""The embeddable pass: right for every projection and texture, and a guest that leaves no trace."""

from __future__ import annotations

import ctypes
import threading
import tracemalloc
from collections.abc import Iterator

import moderngl
import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.gl.context import Context
from ssao_gl.gl.executor import FrameExecutor
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import Perspective

from ..conftest import openable
from ..guest_program import FRAMEBUFFER, TEXTURE_2D, I, P, U, alive, disturb, everything, framebuffer, generate

SIZE = (64, 48)
SETTINGS = ao.Settings(method=ao.Alchemy(radius=1.0))
CAMERA = Camera.perspective(0.9, 0.5, 50.0)
DEPTH_FORMATS = {"32F": (0x8CAC, 0x1406, np.float32, 1.0), "24": (0x81A6, 0x1405, np.uint32, 2.0**32 - 1)}


@pytest.fixture(scope="module")
def context(provider: str) -> Iterator[Context]:
    with ao.gl.open(provider) as ctx:
        yield ctx


@pytest.fixture
def effect(context: Context) -> Iterator[ao.Effect]:
    before = alive(context)
    with ao.Effect(context, SIZE, SETTINGS) as made:
        yield made
    context.check_error("the test")
    assert {kind: count for kind, count in alive(context).items() if count > before[kind]} == {}


def eye_depth(camera: Camera, size: tuple[int, int] = SIZE) -> np.ndarray:
    """(h, w) distance along the view axis to a ball on a floor before a wall; 0 above the wall."""
    view = camera.view(size)
    one = np.ones(size[::-1])
    near, far = view.points(one), view.points(2 * one)
    step, start = far - near, 2 * near - far  # the point at depth z is start + z step

    def where(hit: np.ndarray, z: np.ndarray) -> np.ndarray:
        return np.where(hit & (z > 0), z, np.inf)

    with np.errstate(all="ignore"):
        floor = where(step[..., 1] != 0, (-1 - start[..., 1]) / step[..., 1])
        wall = where(start[..., 1] + 7 * step[..., 1] < 1.5, 7 * one)
        off = start - np.array([0.2, -0.4, -5.0])
        a, b, c = (step**2).sum(-1), (step * off).sum(-1), (off**2).sum(-1) - 0.6**2
        ball = where(b * b > a * c, (-b - np.sqrt(b * b - a * c)) / a)
        z = np.minimum(np.minimum(floor, wall), ball)
    return np.where(np.isfinite(z), z, 0)


def window_depth(camera: Camera, z: np.ndarray) -> np.ndarray:
    """(h, w) float64: what a depth buffer holds for eye depth ``z``, background included."""
    view = camera.view(z.shape[::-1])
    m = view.projection
    ndc = (-m[2, 2] * z + m[2, 3]) / (view.w1 * z + view.w0 + (z == 0))
    return np.where(z > 0, 0.5 + 0.5 * ndc, view.depth_constants["u_depth_far"])


def depth_texture(ctx: Context, depth: np.ndarray, kind: str = "32F") -> int:
    """GL name of a true depth texture with comparison and linear filtering on, as a shadow map has."""
    gl = ctx.functions
    internal, type_, dtype, scale = DEPTH_FORMATS[kind]
    data = np.ascontiguousarray(np.round(depth[::-1] * scale) if scale > 1 else depth[::-1]).astype(dtype).tobytes()
    name = generate(ctx, "Textures", 1)[0]
    gl("glActiveTexture", None, U)(0x84C0)
    gl("glBindTexture", None, U, U)(TEXTURE_2D, name)
    gl("glPixelStorei", None, U, I)(0x0CF5, 4)
    gl("glTexImage2D", None, U, I, I, I, I, I, U, U, P)(
        TEXTURE_2D, 0, internal, depth.shape[1], depth.shape[0], 0, 0x1902, type_, data
    )
    for pname, value in ((0x884C, 0x884E), (0x884D, 0x0204), (0x2801, 0x2703), (0x2800, 0x2601)):
        gl("glTexParameteri", None, U, U, I)(TEXTURE_2D, pname, value)
    gl("glBindTexture", None, U, U)(TEXTURE_2D, 0)
    return name


def delete(ctx: Context, kind: str, *names: int) -> None:
    ctx.functions(f"glDelete{kind}", None, I, P)(len(names), ctypes.addressof((U * len(names))(*names)))


def color_texture(ctx: Context, size: tuple[int, int] = SIZE) -> moderngl.Texture:
    rgb = np.zeros((size[1], size[0], 4), np.uint8)
    rgb[..., 0], rgb[..., 1], rgb[..., 2:] = 230, np.linspace(60, 255, size[0]), 200
    return ctx.mgl.texture(size, 4, rgb.tobytes())


def pixels(ctx: Context, texture: moderngl.Texture) -> np.ndarray:
    """(h, w, 4) uint8, row 0 on top."""
    fbo = ctx.mgl.framebuffer([texture])
    data = np.frombuffer(fbo.read(components=4), np.uint8).reshape(texture.size[1], texture.size[0], 4)[::-1]
    fbo.release()
    return data


def shaded(ctx: Context, effect: ao.Effect, camera: Camera, kind: str = "32F") -> np.ndarray:
    """Visibility (h, w) uint8 by way of window depth, given as a GL name."""
    name = depth_texture(ctx, window_depth(camera, eye_depth(camera, effect.size)), kind)
    result = pixels(ctx, effect.apply(depth=name, camera=camera))[..., 0]
    delete(ctx, "Textures", name)
    return result


def by_eye_depth(ctx: Context, effect: ao.Effect, camera: Camera) -> np.ndarray:
    """The same by eye depth, given as moderngl's texture."""
    z = eye_depth(camera, effect.size)
    texture = ctx.mgl.texture(effect.size, 1, z[::-1].astype("f4").tobytes(), dtype="f4")
    result = pixels(ctx, effect.apply(depth=texture, depth_kind="eye", camera=camera))[..., 0]
    texture.release()
    return result


def reversed_infinite(near: float = 0.5, yfov: float = 0.9) -> Camera:
    m = Perspective(yfov, near).matrix(SIZE)
    m[2] = (0, 0, 0, near)
    return Camera.from_matrix(m, clip="0..1")


def reversed_finite(near: float = 0.5, far: float = 50.0, yfov: float = 0.9) -> Camera:
    m = Perspective(yfov, near).matrix(SIZE)
    m[2] = (0, 0, near / (far - near), far * near / (far - near))
    return Camera.from_matrix(m, clip="0..1")


CAMERAS = {
    "standard": CAMERA,
    "infinite": Camera.perspective(0.9, 0.5),
    "reversed": reversed_finite(),
    "reversed infinite": reversed_infinite(),
    "off-centre": Camera.pinhole(50, 48, 27, 30, SIZE, znear=0.5, zfar=50),
    "orthographic": Camera.orthographic(4.0, 0.5, 20.0),
}
SAME_PICTURE = ("standard", "infinite", "reversed", "reversed infinite")


@pytest.mark.parametrize("name", CAMERAS)
def test_window_depth_of_any_projection_agrees_with_eye_depth(context: Context, effect: ao.Effect, name: str) -> None:
    camera = CAMERAS[name]
    direct = by_eye_depth(context, effect, camera).astype(int)
    assert direct.min() < 240 and direct.max() == 255
    close = np.abs(shaded(context, effect, camera) - direct) <= 2
    assert close.mean() >= 0.995
    if name in SAME_PICTURE:
        assert (np.abs(direct - by_eye_depth(context, effect, CAMERA)) <= 2).mean() >= 0.995


def test_a_24_bit_depth_buffer_is_precise_enough(context: Context, effect: ao.Effect) -> None:
    close = np.abs(shaded(context, effect, CAMERA, "24").astype(int) - by_eye_depth(context, effect, CAMERA)) <= 3
    assert close.mean() >= 0.99


def test_a_floor_is_not_mirrored_or_turned(context: Context, effect: ao.Effect) -> None:
    """The shadow of contact lies under the ball, right of the middle and below it."""
    dark = 255.0 - by_eye_depth(context, effect, Camera.perspective(0.6, 0.5, 50.0))
    rows, columns = np.indices(dark.shape)
    near_ball = (rows > 20) & (rows < 44) & (columns > 14) & (columns < 60)
    weight = np.where(near_ball, dark, 0)
    assert (weight * columns).sum() / weight.sum() > SIZE[0] / 2 + 1
    assert (weight * rows).sum() / weight.sum() > SIZE[1] / 2 + 3


def test_depth_as_object_and_as_name_are_one(context: Context, effect: ao.Effect) -> None:
    depth = window_depth(CAMERA, eye_depth(CAMERA)).astype("f4")
    texture = context.mgl.texture(SIZE, 1, depth[::-1].tobytes(), dtype="f4")
    results = [
        pixels(context, effect.apply(depth=given, camera=CAMERA)) for given in (texture, texture.glo, np.uint32(texture.glo))
    ]
    assert (results[0] == results[1]).all() and (results[0] == results[2]).all()
    texture.release()


def test_a_name_that_is_used_again_is_the_new_texture(context: Context, effect: ao.Effect) -> None:
    first = shaded(context, effect, CAMERA)  # makes and deletes: drivers hand the same name out again
    again = shaded(context, effect, CAMERAS["infinite"], "24")
    assert (np.abs(first.astype(int) - again) <= 3).mean() > 0.99
    texture = context.mgl.texture(SIZE, 1, np.zeros(SIZE, "f4").tobytes(), dtype="f4")
    assert (pixels(context, effect.apply(depth=texture.glo, depth_kind="eye", camera=CAMERA))[..., 0] == 255).all()
    texture.release()


def test_normals_and_colour(context: Context, effect: ao.Effect) -> None:
    z = eye_depth(CAMERA)
    depth = context.mgl.texture(SIZE, 1, z[::-1].astype("f4").tobytes(), dtype="f4")
    color = color_texture(context)
    up = np.zeros((SIZE[1], SIZE[0], 4), "f4")
    up[..., 1] = 1
    normal = context.mgl.texture(SIZE, 4, up.tobytes(), dtype="f4")
    plain = pixels(context, color)
    image = pixels(context, effect.apply(depth=depth, depth_kind="eye", camera=CAMERA, color=color))
    visible = pixels(context, effect.apply(depth=depth, depth_kind="eye", camera=CAMERA))[..., 0]
    assert (image[visible == 255] == plain[visible == 255]).all()
    assert (image[visible < 220, :3] <= plain[visible < 220, :3]).all() and image[visible < 220, 0].mean() < 225
    turned = pixels(context, effect.apply(depth=depth, depth_kind="eye", camera=CAMERA, normal=normal))[..., 0]
    assert (turned != visible).any()
    for texture in (depth, color, normal):
        texture.release()


def test_the_target_gets_what_is_returned(context: Context, effect: ao.Effect) -> None:
    depth = depth_texture(context, window_depth(CAMERA, eye_depth(CAMERA)))
    color = color_texture(context)
    mine = context.mgl.framebuffer([context.mgl.texture(SIZE, 4)])
    for given in ({"color": color}, {}):
        for target in (mine, mine.glo):
            mine.clear(0.3, 0.3, 0.3, 0.3)
            returned = pixels(context, effect.apply(depth=depth, camera=CAMERA, target=target, **given))
            drawn = np.frombuffer(mine.read(components=4), np.uint8).reshape(SIZE[1], SIZE[0], 4)[::-1]
            assert (drawn[..., 0] == returned[..., 0]).all() and drawn[..., 0].std() > 2
            assert not given or (drawn == returned).all()
    delete(context, "Textures", depth)
    for made in (*mine.color_attachments, mine, color):
        made.release()


def test_a_target_of_srgb_gets_the_same_bytes(context: Context, effect: ao.Effect) -> None:
    """They are sRGB already, also where desktop OpenGL would convert what is drawn."""
    if context.api == "es":
        return  # OpenGL ES always converts into such a target
    color, depth = color_texture(context), depth_texture(context, window_depth(CAMERA, eye_depth(CAMERA)))
    target = context.mgl.framebuffer([context.mgl.texture(SIZE, 4, internal_format=0x8C43)])  # SRGB8_ALPHA8
    gl, SRGB = context.functions, 0x8DB9
    gl("glEnable", None, U)(SRGB)
    returned = effect.apply(depth=depth, camera=CAMERA, color=color, target=target)
    assert gl("glIsEnabled", ctypes.c_ubyte, U)(SRGB)
    gl("glDisable", None, U)(SRGB)
    drawn = np.frombuffer(target.color_attachments[0].read(), np.uint8).reshape(SIZE[1], SIZE[0], 4)[::-1]
    assert (drawn == pixels(context, returned)).all()
    delete(context, "Textures", depth)
    for made in (*target.color_attachments, target, color):
        made.release()


def test_only_the_first_of_the_targets_attachments_is_drawn(context: Context, effect: ao.Effect) -> None:
    depth = depth_texture(context, window_depth(CAMERA, eye_depth(CAMERA)))
    mine = context.mgl.framebuffer([context.mgl.texture(SIZE, 4) for _ in range(2)])
    mine.clear(0.6, 0.6, 0.6, 0.6)
    context.functions("glBindFramebuffer", None, U, U)(FRAMEBUFFER, mine.glo)
    context.functions("glDrawBuffers", None, I, P)(2, ctypes.addressof((U * 2)(0, 0x8CE1)))
    effect.apply(depth=depth, camera=CAMERA, target=mine.glo)
    context.functions("glBindFramebuffer", None, U, U)(FRAMEBUFFER, mine.glo)
    assert context.functions.integers(0x8825) == [0] and context.functions.integers(0x8826) == [0x8CE1]
    assert set(mine.read(components=4, attachment=1)) == {153}
    assert len(set(mine.read(components=4))) > 10
    delete(context, "Textures", depth)
    for made in (*mine.color_attachments, mine):
        made.release()


def test_what_cannot_be_read_or_drawn_is_named(context: Context, effect: ao.Effect) -> None:
    small, color = color_texture(context, (32, 24)), color_texture(context)
    loop, tiny = context.mgl.framebuffer([color]), context.mgl.framebuffer([small])
    depth = depth_texture(context, np.ones(SIZE[::-1]))
    nothing = generate(context, "Framebuffers", 1)[0]

    def fails(message: str, **arguments: object) -> None:
        with pytest.raises(ao.FormatError, match=message):
            effect.apply(**{"depth": depth, "camera": CAMERA, **arguments})  # type: ignore[arg-type]

    fails("depth texture is 32x24, the effect 64x48; call resize", depth=small)
    if context.api == "gl" or context.mgl.version_code >= 310:
        fails("color texture is 32x24", color=small.glo)
    fails("no texture with the GL name 9999", depth=9999)
    fails(
        "depth: expected a moderngl.Texture or a GL name, got ndarray; for arrays there is ssao_gl.apply", depth=np.ones(SIZE)
    )
    fails("target: expected a moderngl.Framebuffer or a GL name, got str", target="window")
    fails("target is 32x24, smaller than the effect's 64x48", target=tiny)
    fails("no framebuffer with the GL name 9999", target=9999)
    fails("no framebuffer|incomplete", target=nothing)
    fails("colour texture is attached to the target", target=loop.glo, color=color)
    fails("colour texture is attached to the target", target=loop, color=color.glo)
    with pytest.raises(ao.SettingsError, match="depth kind 'metres'"):
        effect.apply(depth=depth, camera=CAMERA, depth_kind="metres")
    delete(context, "Textures", depth)
    delete(context, "Framebuffers", nothing)
    for made in (loop, tiny, small, color):
        made.release()


def test_construction_says_what_is_wrong(context: Context) -> None:
    with pytest.raises(ao.SettingsError, match="Effect: give bitmask a radius, in the units of your depth"):
        ao.Effect(context, SIZE)
    with pytest.raises(ao.SettingsError, match="size 0x48"):
        ao.Effect(context, (0, 48), SETTINGS)
    with pytest.raises(ao.ContextError, match=r"expected a moderngl.Context or a context of ssao_gl.gl, got str"):
        ao.Effect("egl", SIZE, SETTINGS)  # type: ignore[arg-type]


def test_resize(context: Context, effect: ao.Effect) -> None:
    first = by_eye_depth(context, effect, CAMERA)
    held = alive(context)
    effect.resize(96, 72)
    assert by_eye_depth(context, effect, CAMERA).shape == (72, 96)
    assert alive(context) == held
    effect.resize(*SIZE)
    assert (by_eye_depth(context, effect, CAMERA) == first).all()
    with pytest.raises(ao.SettingsError, match="size 96x0"):
        effect.resize(96, 0)
    assert effect.size == SIZE


def test_settings_may_change_between_calls(context: Context, effect: ao.Effect) -> None:
    first = by_eye_depth(context, effect, CAMERA)
    held = alive(context)
    effect.settings = ao.Settings(method=ao.Alchemy(radius=0.05))
    assert by_eye_depth(context, effect, CAMERA).mean() > first.mean() + 1
    assert alive(context) == held
    effect.settings = ao.Settings(method=ao.Alchemy(radius=1.0), blur=None)
    assert (by_eye_depth(context, effect, CAMERA) != first).any()
    effect.settings = SETTINGS
    assert (by_eye_depth(context, effect, CAMERA) == first).all()
    with pytest.raises(ao.SettingsError, match="radius"):
        effect.settings = ao.Settings()


@pytest.mark.parametrize("given", [(), ("normal",), ("color",), ("color", "normal", "target")], ids="-".join)
def test_odd_state_changes_nothing_and_is_not_changed(context: Context, given: tuple[str, ...]) -> None:
    ctx = context
    z = eye_depth(CAMERA)
    textures = {
        "depth": ctx.mgl.texture(SIZE, 1, z[::-1].astype("f4").tobytes(), dtype="f4"),
        "color": color_texture(ctx),
        "normal": ctx.mgl.texture(SIZE, 4, np.full((*SIZE, 4), 0.5, "f4").tobytes(), dtype="f4"),
    }
    arguments = {name: textures[name] for name in ("depth", *given) if name in textures}
    before, home = ctx.mgl.fbo, ctx.mgl.framebuffer([ctx.mgl.texture((4, 4), 4)])
    home.use()
    with ao.Effect(ctx, SIZE, SETTINGS) as effect:
        calm = pixels(ctx, effect.apply(camera=CAMERA, depth_kind="eye", **arguments))
    target = framebuffer(ctx, 2, SIZE) if "target" in given else None
    disturb(ctx)
    odd = everything(ctx)
    record = ctx.mgl.fbo
    effect = ao.Effect(ctx, SIZE, SETTINGS)
    assert everything(ctx) == odd
    result = effect.apply(camera=CAMERA, depth_kind="eye", target=target, **arguments)
    assert everything(ctx) == odd
    with pytest.raises(ao.FormatError):
        effect.apply(camera=CAMERA, depth=9999)
    assert everything(ctx) == odd
    with pytest.MonkeyPatch.context() as patch:
        drawn: list[str] = []
        draw = FrameExecutor._fullscreen
        patch.setattr(
            FrameExecutor, "_fullscreen", lambda *a, **k: 1 / 0 if len(drawn) == 3 else (drawn.append(""), draw(*a, **k))
        )
        with pytest.raises(ZeroDivisionError):
            effect.apply(camera=CAMERA, depth_kind="eye", target=target, **arguments)
    assert everything(ctx) == odd
    effect.apply(camera=CAMERA, depth_kind="eye", target=target, timed=True, **arguments)
    effect.resize(*SIZE)
    assert everything(ctx) == odd
    result = effect.apply(camera=CAMERA, depth_kind="eye", target=target, **arguments)
    assert ctx.mgl.fbo is record and ctx.mgl.error == "GL_NO_ERROR"
    neutral(ctx)
    assert (pixels(ctx, result) == calm).all()
    if target is not None:
        shown = np.zeros((SIZE[1], SIZE[0], 4), np.uint8)
        ctx.functions("glBindFramebuffer", None, U, U)(FRAMEBUFFER, target)
        ctx.functions("glReadPixels", None, I, I, I, I, U, U, P)(0, 0, *SIZE, 0x1908, 0x1401, shown.ctypes.data)
        assert (shown[::-1] == calm).all(), "the target too, whatever the caller's masks"
    disturb(ctx)
    odd = everything(ctx)
    effect.release()
    assert everything(ctx) == odd
    neutral(ctx)
    before.use()
    for made in (*textures.values(), *home.color_attachments, home):
        made.release()


def neutral(ctx: Context) -> None:
    """What the tests' own reading and uploading needs after :func:`disturb`."""
    from ssao_gl.gl.guest_state import GlState

    state = GlState(ctx.functions, es=ctx.api == "es", version=ctx.mgl.version_code)
    state.neutral(state.snapshot())
    for unit in range(16):
        ctx.functions("glBindSampler", None, U, U)(unit, 0)


def test_a_running_transform_feedback_is_paused(context: Context, effect: ao.Effect) -> None:
    ctx, gl = context, context.functions
    if ctx.api == "gl" and ctx.mgl.version_code < 400:
        return  # OpenGL 3.3 cannot pause it
    version = "#version 300 es\nprecision highp float;" if ctx.api == "es" else "#version 330"
    program = ctx.mgl.program(
        vertex_shader=f"{version}\nout vec4 v_seen; void main() {{ v_seen = vec4(7.0); gl_Position = vec4(0.0); }}",
        fragment_shader=f"{version}\nin vec4 v_seen; out vec4 c; void main() {{ c = v_seen; }}",
    )
    array = (ctypes.c_char_p * 1)(b"v_seen")
    gl("glTransformFeedbackVaryings", None, U, I, P, U)(program.glo, 1, ctypes.addressof(array), 0x8C8C)
    gl("glLinkProgram", None, U)(program.glo)
    buffer, vao = generate(ctx, "Buffers", 1)[0], generate(ctx, "VertexArrays", 1)[0]
    gl("glBindBuffer", None, U, U)(0x8C8E, buffer)
    gl("glBufferData", None, U, ctypes.c_ssize_t, P, U)(0x8C8E, 64, None, 0x88E4)
    gl("glBindBufferBase", None, U, U, U)(0x8C8E, 0, buffer)
    gl("glBindVertexArray", None, U)(vao)
    gl("glUseProgram", None, U)(program.glo)
    gl("glBeginTransformFeedback", None, U)(4)  # of triangles: SwiftShader minds the kind even while paused
    depth = ctx.mgl.texture(SIZE, 1, eye_depth(CAMERA)[::-1].astype("f4").tobytes(), dtype="f4")
    seen = effect.apply(depth=depth, depth_kind="eye", camera=CAMERA)
    assert gl.integers(0x8E24) == [1] and gl.integers(0x8E23) == [0]
    gl("glEndTransformFeedback", None)()
    assert pixels(ctx, seen)[..., 0].std() > 2
    gl("glBindVertexArray", None, U)(0)
    gl("glUseProgram", None, U)(0)
    delete(ctx, "Buffers", buffer)
    delete(ctx, "VertexArrays", vao)
    for made in (program, depth):
        made.release()


def test_many_frames_leave_nothing_behind(context: Context, effect: ao.Effect) -> None:
    depth = depth_texture(context, window_depth(CAMERA, eye_depth(CAMERA)))
    for _ in range(5):
        effect.apply(depth=depth, camera=CAMERA, timed=True)
    held = alive(context)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(50):
            effect.apply(depth=depth, camera=CAMERA, timed=True)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert alive(context) == held and grown < 20_000
    delete(context, "Textures", depth)


def test_times_and_description_name_every_pass(context: Context, effect: ao.Effect) -> None:
    assert not effect.times
    depth = depth_texture(context, window_depth(CAMERA, eye_depth(CAMERA)))
    effect.apply(depth=depth, camera=CAMERA, timed=True)
    assert [p.name for p in effect.times] == ["linearize", "normals", "alchemy", "blur x", "blur y"]
    assert all(p.ms >= 0 and p.clock == ("wall" if context.software else "gpu") for p in effect.times)
    assert all(f" {p.name}" in effect.describe(color=False) for p in effect.times)
    delete(context, "Textures", depth)


def test_release_twice_and_use_after(context: Context) -> None:
    effect = ao.Effect(context, SIZE, SETTINGS)
    effect.release()
    effect.release()
    depth = depth_texture(context, np.ones(SIZE[::-1]))
    with pytest.raises(ao.ContextError, match="released"):
        effect.apply(depth=depth, camera=CAMERA)
    delete(context, "Textures", depth)


def test_a_result_that_is_bound_when_it_goes(context: Context) -> None:
    """Its name stands for nothing then: OpenGL takes it off its unit, records no error, and makes no texture of that name."""
    camera = Camera.perspective(0.9, 0.5, 50.0)
    depth = context.mgl.texture(SIZE, 1, eye_depth(camera)[::-1].astype("f4").tobytes(), dtype="f4")
    context.check_error("the caller's own")
    effect = ao.Effect(context, SIZE, ao.Settings(method=ao.Alchemy(radius=0.5)))
    result = effect.apply(depth=depth, camera=camera, depth_kind="eye")
    result.use(3)
    name = result.glo
    effect.release()
    context.check_error("after the effect")
    context.functions("glActiveTexture", None, U)(0x84C0 + 3)
    assert context.functions.integers(0x8069)[0] == 0, "nothing is bound to the unit"
    assert not context.functions("glIsTexture", ctypes.c_ubyte, U)(name)
    context.functions("glActiveTexture", None, U)(0x84C0)
    depth.release()


def test_wrapping_the_current_context_changes_nothing(context: Context) -> None:
    disturb(context)
    odd = everything(context)
    wrapped = ao.gl.wrap_current(context.functions.get_proc, api=context.api)
    assert everything(context) == odd
    with ao.Effect(wrapped, SIZE, SETTINGS) as effect:
        assert everything(context) == odd
        neutral(context)
        seen = by_eye_depth(wrapped, effect, CAMERA)
    wrapped.release()
    with ao.Effect(context.mgl, SIZE, SETTINGS) as effect:  # moderngl's context, wherever it came from
        assert (by_eye_depth(context, effect, CAMERA) == seen).all()


def test_wrapping_says_what_is_wrong(context: Context) -> None:
    other = {"es": "gl", "gl": "es"}[context.api]
    with pytest.raises(ao.ContextError, match=r"the current context is '.*', not "):
        ao.gl.wrap_current(context.functions.get_proc, api=other)  # type: ignore[arg-type]
    with pytest.raises(ao.ContextError, match="glGetString"):
        ao.gl.wrap_current(lambda name: 0)
    reasons: list[str] = []

    def elsewhere() -> None:  # contexts are current in one thread
        for get_proc in (None, context.functions.get_proc):
            try:
                ao.gl.wrap_current(get_proc)
            except ao.ContextError as reason:
                reasons.append(str(reason))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert len(reasons) == 2 and all("no OpenGL context is current in this thread" in reason for reason in reasons)


@pytest.mark.skipif("egl-gl" not in openable(), reason="moderngl's backend egl needs the same library as egl-gl")
def test_a_context_that_moderngl_made() -> None:
    mgl = moderngl.create_context(standalone=True, backend="egl")
    mgl.gc_mode = "context_gc"
    try:
        fbo = mgl.framebuffer([mgl.texture(SIZE, 4)])
        fbo.use()
        with ao.Effect(mgl, SIZE, SETTINGS) as effect:
            depth = mgl.texture(SIZE, 1, eye_depth(CAMERA)[::-1].astype("f4").tobytes(), dtype="f4")
            effect.apply(depth=depth, depth_kind="eye", camera=CAMERA, target=fbo)
            assert mgl.fbo is fbo
            assert np.frombuffer(fbo.read(components=4), np.uint8).std() > 5
        assert mgl.error == "GL_NO_ERROR"
    finally:
        mgl.release()
