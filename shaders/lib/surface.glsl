// What a surface writes into the G-buffer: linear depth (scene units), view-space normals turned to the viewer, base colour
// with the direct light in alpha. Each target is there only when some pass reads it.
#include "lib/normal.glsl"

#ifdef BEHIND
uniform sampler2D u_front;  // linear depth of the first layer
uniform vec2 u_front_texel;
#endif
#ifdef LOG_DEPTH
uniform vec2 u_log;  // 1 / near, 1 / log2(far / near)
#endif
uniform vec3 u_light;  // unit vector to the light, view space

#ifdef DEPTH_TARGET
layout(location = DEPTH_TARGET) out vec4 out_z;
#endif
#ifdef NORMAL_TARGET
layout(location = NORMAL_TARGET) out vec4 out_normal;
#endif
#ifdef SHADING_NORMAL_TARGET
layout(location = SHADING_NORMAL_TARGET) out vec4 out_shading_normal;
#endif
#ifdef COLOR
layout(location = COLOR) out vec4 out_color;
#endif

#ifdef BEHIND
// Depth peeling (Everitt 2001): only what lies behind the first layer by more than its own rounding is seen.
bool ssao_hidden(float z) { return z <= SAMPLE(u_front, gl_FragCoord.xy * u_front_texel).r * (1.0 + 1e-5); }
#endif

void ssao_write_depth(float z) {
#ifdef LOG_DEPTH
    gl_FragDepth = log2(max(z * u_log.x, 1.0)) * u_log.y;
#endif
#ifdef DEPTH_TARGET
    out_z = vec4(z);
#endif
}

// geometric: normal of the surface itself; n: for shading. Both unit, on the viewer's side.
void ssao_write_normals(vec3 geometric, vec3 n) {
#ifdef NORMAL_TARGET
#ifdef GEOMETRIC
    out_normal = vec4(ssao_encode_normal(geometric), 0.0, 0.0);
#else
    out_normal = vec4(ssao_encode_normal(n), 0.0, 0.0);
#endif
#endif
#ifdef SHADING_NORMAL_TARGET
    out_shading_normal = vec4(ssao_encode_normal(n), 0.0, 0.0);
#endif
}

#ifdef COLOR
// color: sRGB.
void ssao_write_color(vec3 color, vec3 n) { out_color = vec4(color, max(0.0, dot(n, u_light))); }
#endif
