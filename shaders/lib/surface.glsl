// What a surface writes into the G-buffer: linear depth (scene units), view-space normals turned to the viewer, base colour
// with the direct light in alpha. Each target is there only when some pass reads it.
#include "lib/normal.glsl"

#ifdef BEHIND
uniform sampler2D u_front;  // linear depth of the first layer
uniform float u_gap;        // between the layers at least, scene units
uniform vec2 u_front_step;    // one texel of the target, as uv of the image
uniform float u_front_scale;  // pixels along each side of it
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
#ifdef BAKED_TARGET
layout(location = BAKED_TARGET) out vec4 out_baked;
#endif

#ifdef MATERIAL_TARGET
layout(location = MATERIAL_TARGET) out vec4 out_material;
#endif
#ifdef LABELS_TARGET
layout(location = LABELS_TARGET) out uvec4 out_label;
uniform ivec3 u_label;  // numbers of the thing, of its first copy, and of its material
#ifdef COPIES
flat VARYING int v_copy;  // which of its copies
#endif
#endif

#ifdef BEHIND
// Where in the image the fragment lies, as uv: a texel of several pixels is drawn for the middle of one of them.
vec2 ssao_place(vec2 image_texel) {
    return (floor(gl_FragCoord.xy) + (floor(0.5 * u_front_scale) + 0.5) / u_front_scale) * u_front_step;
}

// Depth peeling (Everitt 2001): only what lies behind the first layer by the gap, and by more than its own rounding, is seen.
// What lies nearer is within the slab of the first (Mara et al., "Deep G-Buffers for Stable Global Illumination", 2016).
float ssao_front() { return SAMPLE(u_front, ssao_place(vec2(0.0))).r; }
bool ssao_hidden(float z) { return z <= ssao_front() * (1.0 + 1e-5) + u_gap; }
#else
// Where in the image the fragment lies, as uv.
vec2 ssao_place(vec2 image_texel) { return gl_FragCoord.xy * image_texel; }
#endif

void ssao_write_depth(float z) {
#ifdef LOG_DEPTH
    gl_FragDepth = log2(max(z * u_log.x, 1.0)) * u_log.y;
#endif
#ifdef DEPTH_TARGET
    out_z = vec4(z);
#endif
#ifdef BAKED_TARGET
    out_baked = vec4(1.0);
#endif
#ifdef MATERIAL_TARGET
    out_material = vec4(1.0, 0.0, 0.0, 1.0);
#endif
#ifdef LABELS_TARGET
    out_label = uvec4(u_label, 0);
#ifdef COPIES
    out_label.y += uint(v_copy);
#endif
#endif
}

#ifdef MATERIAL_TARGET
// Roughness and metalness of what shines; after its depth, with which it is written as matt.
void ssao_write_material(vec2 material) { out_material = vec4(material, 1.0, 1.0); }
#endif

#ifdef BAKED_TARGET
// Visibility that the surface keeps; after its depth, with which it is written as open.
void ssao_write_baked(float visibility) { out_baked = vec4(visibility); }
#endif

// The same for what a ray met in the fragment and no triangle: the depth test goes by it, under the projection of the draw.
void ssao_write_met_depth(float z, mat4 projection) {
    ssao_write_depth(z);
#ifndef LOG_DEPTH
    vec2 clip = projection[2].zw * -z + projection[3].zw;
    gl_FragDepth = clamp(0.5 + 0.5 * clip.x / clip.y, 0.0, 1.0);
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
