// A triangle's surface.
#needs es300
#define COPIES
#include "lib/surface.glsl"
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
#ifdef BAKED_VERTEX
VARYING float v_baked;  // visibility
#endif
#ifdef BAKED_TEXTURE
uniform sampler2D u_baked;      // visibility in red
uniform float u_baked_strength;  // 0: all open, 1: as it is
VARYING vec2 v_baked;
#endif
#ifdef SHINY
uniform vec2 u_material;  // roughness, metalness
#endif
uniform vec4 u_color;  // base colour, sRGB; with a texture linear

void main() {
#ifdef BEHIND
    if (ssao_hidden(-v_position.z)) discard;
#endif
    ssao_write_depth(-v_position.z);
#ifdef SHINY
    ssao_write_material(u_material);
#endif
#ifdef BAKED_VERTEX
    ssao_write_baked(v_baked);
#endif
#ifdef BAKED_TEXTURE
    ssao_write_baked(mix(1.0, SAMPLE(u_baked, v_baked).r, u_baked_strength));
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
    ssao_write_normals(geometric, n);
#ifdef COLOR
#if defined(TEXTURED)
    vec3 base = SAMPLE(u_texture, v_uv).rgb * u_color.rgb;
#if defined(VERTEX_COLOR) && !defined(BAKED_IN_COLOR)
    base *= ssao_srgb_to_linear(v_color.rgb);
#endif
    vec3 color = ssao_linear_to_srgb(base);
#elif defined(VERTEX_COLOR) && !defined(BAKED_IN_COLOR)
    vec3 color = v_color.rgb * u_color.rgb;
#else
    vec3 color = u_color.rgb;
#endif
    ssao_write_color(color, n);
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
