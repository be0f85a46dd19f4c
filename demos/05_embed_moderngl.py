"""A moderngl program with a scene pass of its own; ambient occlusion comes in as one call after it."""

import argparse
from pathlib import Path

import moderngl
import numpy as np
from PIL import Image

import ssao_gl as ao
from ssao_gl.scene.sample_scene import box

VERTEX = """
in vec3 a_position; in vec3 a_normal; uniform mat4 u_clip; out vec3 v_normal;
void main() {  // a town of 16 x 16 blocks, one instance each
    vec2 cell = vec2(gl_InstanceID % 16, gl_InstanceID / 16) - 7.5;
    float height = gl_InstanceID % 3 == 0 ? 0.1 : 0.3 + 0.9 * fract(sin(dot(cell, vec2(12.99, 78.23))) * 43758.5);
    gl_Position = u_clip * vec4(a_position * vec3(0.5, height, 0.5) + vec3(cell.x, height, cell.y), 1.0);
    v_normal = a_normal; }"""
FRAGMENT = """in vec3 v_normal; out vec4 color;
void main() { color = vec4(vec3(0.9, 0.85, 0.78) * (0.85 + 0.15 * dot(v_normal, vec3(0.3, 0.8, 0.5))), 1.0); }"""


def program_context():
    try:
        return moderngl.create_context(standalone=True, backend="egl")
    except Exception:  # no EGL, or no desktop OpenGL in it: whatever ssao_gl can find
        return ao.gl.open().mgl


def main(folder, size):
    ctx = program_context()
    head = "#version 300 es\nprecision highp float;" if "ES" in ctx.info["GL_VERSION"] else "#version 330"
    program = ctx.program(vertex_shader=head + VERTEX, fragment_shader=head + "\n" + FRAGMENT)
    positions, triangles, normals = box()
    vertices = ctx.buffer(np.hstack([positions, normals]).astype("f4").tobytes())
    town = ctx.vertex_array(program, [(vertices, "3f 3f", "a_position", "a_normal")], ctx.buffer(triangles.tobytes()))
    color, depth = ctx.texture(size, 4), ctx.depth_texture(size)
    scene, screen = ctx.framebuffer([color], depth), ctx.framebuffer([ctx.texture(size, 4)])
    camera = ao.Camera.perspective(0.7, 1.0, 60.0, ao.look_at((14, 17, 22), (0, 0, 0)))
    program["u_clip"].write((camera.lens.matrix(size) @ np.linalg.inv(camera.pose)).T.astype("f4").tobytes())

    effect = ao.Effect(ctx, size, ao.Settings(method=ao.Alchemy(radius=0.8)))  # once; resize() when the window changes
    scene.use()
    scene.clear(1, 1, 1, 1)
    ctx.enable(moderngl.DEPTH_TEST)
    town.render(instances=256)
    effect.apply(depth=depth, color=color, camera=camera, target=screen)  # your GL state is as you left it
    effect.release()
    shown = Image.frombytes("RGBA", size, screen.read(components=4))
    shown.transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(folder / "05_embed_moderngl.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    main(arguments.o, tuple(map(int, arguments.size.split("x"))))
