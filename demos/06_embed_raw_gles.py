"""A program in raw OpenGL ES, without moderngl: it draws by ctypes and hands its textures over by their GL names."""

import argparse
import ctypes as c
from pathlib import Path

import numpy as np
from PIL import Image

import ssao_gl as ao

VERTEX = """#version 300 es
precision highp float; uniform mat4 u_clip;
void main() {  // a bowl of cubes out of thin air: 36 vertices an instance
    int side = gl_VertexID / 6, k = gl_VertexID % 6;
    vec3 p = vec3(k % 3 == 1 || k == 2 ? 1 : -1, k == 2 || k > 3 ? 1 : -1, side < 3 ? 1 : -1);
    p = side % 3 == 0 ? p : side % 3 == 1 ? p.yzx : p.zxy;
    vec2 cell = vec2(gl_InstanceID % 8, gl_InstanceID / 8) - 3.5;
    gl_Position = u_clip * vec4(p + 2.0 * vec3(cell.x, 0.6 * length(cell), cell.y), 1.0);
}"""
FRAGMENT = "#version 300 es\nprecision highp float; out vec4 color; void main() { color = vec4(0.78, 0.84, 0.9, 1.0); }"


def main(folder, size):
    get_proc = ao.gl.open(api="es").functions.get_proc  # in your program: eglGetProcAddress, glfwGetProcAddress ...

    def gl(name, *given, result=None):
        kinds = [c.c_int if isinstance(a, int) else c.c_float if isinstance(a, float) else c.c_void_p for a in given]
        return c.CFUNCTYPE(result, *kinds)(get_proc(name))(*(c.addressof(a) if isinstance(a, c.Array) else a for a in given))

    gl("glGenTextures", 3, textures := (c.c_int * 3)())
    gl("glGenFramebuffers", 2, framebuffers := (c.c_int * 2)())
    (color, depth, picture), (screen, scene) = textures, framebuffers
    for texture, internal in ((color, 0x8058), (depth, 0x81A6), (picture, 0x8058)):  # RGBA8, DEPTH_COMPONENT24
        gl("glBindTexture", 0x0DE1, texture)
        gl("glTexStorage2D", 0x0DE1, 1, internal, *size)
    for framebuffer, attachment, texture in ((screen, 0x8CE0, picture), (scene, 0x8CE0, color), (scene, 0x8D00, depth)):
        gl("glBindFramebuffer", 0x8D40, framebuffer)
        gl("glFramebufferTexture2D", 0x8D40, attachment, 0x0DE1, texture, 0)
    program = gl("glCreateProgram", result=c.c_int)
    for kind, text in ((0x8B31, VERTEX), (0x8B30, FRAGMENT)):
        shader = gl("glCreateShader", kind, result=c.c_int)
        gl("glShaderSource", shader, 1, (c.c_char_p * 1)(text.encode()), None)
        gl("glCompileShader", shader)
        gl("glAttachShader", program, shader)
    camera = ao.Camera.perspective(0.6, 5.0, 80.0, ao.look_at((18, 24, 26), (0, 2.5, 0)))
    clip = (c.c_float * 16)(*(camera.lens.matrix(size) @ np.linalg.inv(camera.pose)).T.ravel())
    gl("glLinkProgram", program)
    gl("glUseProgram", program)
    gl("glUniformMatrix4fv", 0, 1, 0, clip)
    gl("glViewport", 0, 0, *size)
    gl("glClearColor", 1.0, 1.0, 1.0, 1.0)
    gl("glClear", 0x4100)
    gl("glEnable", 0x0B71)
    gl("glDrawArraysInstanced", 4, 0, 36, 64)

    with ao.Effect(ao.gl.wrap_current(get_proc, api="es"), size, ao.Settings(method=ao.Alchemy(radius=2.0))) as effect:
        effect.apply(depth=depth, color=color, camera=camera, target=screen)

    gl("glBindFramebuffer", 0x8D40, screen)
    gl("glReadPixels", 0, 0, *size, 0x1908, 0x1401, pixels := (c.c_ubyte * (4 * size[0] * size[1]))())
    shown = Image.frombytes("RGBA", size, bytes(pixels))
    shown.transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(folder / "06_embed_raw_gles.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path(), help="folder for the pictures (default: here)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    main(arguments.o, tuple(map(int, arguments.size.split("x"))))
