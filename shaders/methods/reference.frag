// What a depth buffer holds, asked exhaustively: every texel within the radius along many slices. Slow on purpose.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/slice.glsl"
#include "lib/bitmask.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
#ifdef SECOND_LAYER
uniform sampler2D u_z2;
#endif
uniform float u_radius;     // scene units
uniform float u_thickness;  // of what a texel shows, in radii

#ifdef THICK
// The horizon on each side: u of its least angle from the viewer.
#define BLOCKED vec2
void ssao_block(inout vec2 horizon, float near, float far, float side) {
    if (side > 0.0) horizon.y = min(horizon.y, near); else horizon.x = max(horizon.x, near);
}
float ssao_open(vec2 horizon) { return max(0.0, horizon.y - horizon.x); }
#else
// 128 bits of equal measure.
#define BLOCKED uvec4
void ssao_block(inout uvec4 bits, float near, float far, float side) {
    vec4 a = clamp(4.0 * min(near, far) - vec4(0.0, 1.0, 2.0, 3.0), 0.0, 1.0);
    vec4 b = clamp(4.0 * max(near, far) - vec4(0.0, 1.0, 2.0, 3.0), 0.0, 1.0);
    bits |= uvec4(ssao_bits(a.x, b.x), ssao_bits(a.y, b.y), ssao_bits(a.z, b.z), ssao_bits(a.w, b.w));
}
float ssao_open(uvec4 bits) {
    return 1.0 - (ssao_count(bits.x) + ssao_count(bits.y) + ssao_count(bits.z) + ssao_count(bits.w)) / 128.0;
}
#endif

// One texel of one layer: all that lies within the radius, and behind it as far as its thickness.
void ssao_texel(inout BLOCKED blocked, SsaoSlice s, vec3 p, vec3 v, vec2 tap, float z, float side) {
    if (!(z > 0.0)) return;
    vec3 q = ssao_position(tap, z);
    vec3 d = (q - p) / u_radius;
    if (dot(d, d) >= 1.0 || dot(d, d) == 0.0) return;
    vec2 front = ssao_into_slice(s, d, v);
    if (front.x * side <= 0.0) return;  // on steep surfaces a texel beside the slice may slide to its other side
    vec3 back = d - ssao_to_viewer(q) * u_thickness;
    ssao_block(blocked, ssao_u(s, front, side), ssao_u(s, ssao_into_slice(s, back, v), side), side);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    float sum = 0.0, total = 0.0;
    if (z > 0.0) {
        vec3 p = ssao_position(uv, z);
        vec3 v = ssao_to_viewer(p);
        vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
        // Nothing within the radius is nearer to the viewer than this, and so larger on the screen.
        float w = max(ssao_w(max(z - u_radius, 0.0)), 1e-3 * ssao_w(z));
        for (int i = 0; i < SLICES; i++) {
            float angle = (float(i) + 0.5) * (SSAO_PI / float(SLICES));
            vec3 along = ssao_along(v, vec2(cos(angle), sin(angle)));
            vec2 texels = ssao_texels(p, along);
            float reach = length(texels) * u_radius / w;
            vec2 step = texels / max(max(abs(texels.x), abs(texels.y)), 1e-30);
            int count = int(min(reach / length(step), float(MAX_STEPS)));
            SsaoSlice s = ssao_slice(along, v, n);
#ifdef THICK
            vec2 blocked = vec2(0.0, 1.0);
#else
            uvec4 blocked = uvec4(0u);
#endif
            for (int side = -1; side <= 1; side += 2) {
                for (int k = 1; k <= count; k++) {
                    vec2 tap = (floor(gl_FragCoord.xy + float(side * k) * step) + 0.5) * u_texel;
                    if (tap != clamp(tap, vec2(0.0), vec2(1.0))) break;
                    ssao_texel(blocked, s, p, v, tap, SAMPLE(u_z, tap).r, float(side));
#ifdef SECOND_LAYER
                    ssao_texel(blocked, s, p, v, tap, SAMPLE(u_z2, tap).r, float(side));
#endif
                }
            }
            sum += s.weight * ssao_open(blocked);
            total += s.weight;
        }
    }
    ssao_write(total > 0.0 ? sum / total : 1.0, z);
}
