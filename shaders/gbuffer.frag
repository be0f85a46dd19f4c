// Linear depth (scene units), view-space normals turned to the viewer, base colour with the direct light in alpha.
// Each target is there only when some pass reads it.
#needs es300
#include "lib/normal.glsl"
#include "lib/srgb.glsl"

VARYING vec3 v_position;
#ifdef SMOOTH
VARYING vec3 v_normal;
#endif
#ifdef VERTEX_COLOR
VARYING vec4 v_color;
#endif
#ifdef TEXTURED
uniform sampler2D u_texture;  // base colour as linear light, and alpha
VARYING vec2 v_uv;
#endif
#ifdef CUT
uniform float u_cutoff;  // alpha below which there is no surface
#endif
#ifdef BEHIND
uniform sampler2D u_front;  // linear depth of the first layer
uniform float u_gap;        // between the layers at least, scene units
uniform vec2 u_step;        // one texel of the target, as uv of the image
uniform float u_scale;      // pixels along each side of it
#endif
#ifdef LOG_DEPTH
uniform vec2 u_log;  // 1 / near, 1 / log2(far / near)
#endif
uniform vec4 u_color;  // base colour, sRGB; with a texture linear
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

void main() {
#ifdef BEHIND
    // Depth peeling (Everitt 2001): only what lies behind the first layer by the gap, and by more than its own rounding. What
    // lies nearer is within the slab of the first (Mara et al., "Deep G-Buffers for Stable Global Illumination", 2016).
    // The middle of a pixel, where rounding decides nothing.
    vec2 place = (floor(gl_FragCoord.xy) + (floor(0.5 * u_scale) + 0.5) / u_scale) * u_step;
    // A texel of several pixels is drawn beside that pixel: a steep surface must not lie behind itself.
    float beside = (1.0 - 1.0 / u_scale) * fwidth(v_position.z);
    if (-v_position.z <= SAMPLE(u_front, place).r * (1.0 + 1e-5) + u_gap + beside) discard;
#endif
#ifdef LOG_DEPTH
    gl_FragDepth = log2(max(-v_position.z * u_log.x, 1.0)) * u_log.y;
#endif
#ifdef DEPTH_TARGET
    out_z = vec4(-v_position.z);
#endif
#ifdef NORMAL
    // The side of the triangle that is seen, whatever its winding and whatever its normals say.
    vec3 face = cross(dFdx(v_position), dFdy(v_position));
    vec3 seen = dot(face, v_position) > 0.0 ? -face : face;
    // Scaled first: the square of a tiny area would vanish in 32-bit floats.
    seen /= max(max(abs(seen.x), abs(seen.y)), max(abs(seen.z), 1e-37));
    float area2 = dot(seen, seen);
    vec3 geometric = area2 > 0.0 ? seen * inversesqrt(area2) : vec3(0.0, 0.0, 1.0);
    vec3 n = geometric;
#ifdef SMOOTH
    // The interpolated normal, on that side; where it is missing or vanishes the triangle's own stays.
    float length2 = dot(v_normal, v_normal);
    vec3 smoothed = v_normal * inversesqrt(max(length2, 1e-37));
    if (length2 > 1e-37) n = dot(smoothed, geometric) < 0.0 ? -smoothed : smoothed;
#endif
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
#ifdef COLOR
#if defined(TEXTURED)
    vec3 base = SAMPLE(u_texture, v_uv).rgb * u_color.rgb;
#ifdef VERTEX_COLOR
    base *= ssao_srgb_to_linear(v_color.rgb);
#endif
    vec3 color = ssao_linear_to_srgb(base);
#elif defined(VERTEX_COLOR)
    vec3 color = v_color.rgb * u_color.rgb;
#else
    vec3 color = u_color.rgb;
#endif
    out_color = vec4(color, max(0.0, dot(n, u_light)));
#endif
#endif
#ifdef CUT
    // Last, for what is discarded has no derivatives. The picture itself, not its smaller copies: in these, leaves thin out
    // with distance, and rays would see others than we.
    float alpha = u_color.a;
#ifdef TEXTURED
    alpha *= textureLod(u_texture, v_uv, 0.0).a;
#endif
#ifdef VERTEX_COLOR
    alpha *= v_color.a;
#endif
    if (alpha < u_cutoff) discard;
#endif
}
