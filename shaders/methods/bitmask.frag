// Visibility bitmask over slices of the hemisphere: each tap sets the bits that a slab behind its texel hides. The bits are
// of equal cosine-weighted measure (lib/slice.glsl), so counting them is the slice integral.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/slice.glsl"
#include "lib/bits.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_noise;    // (cos, sin) of the first slice's direction, place of the taps between their steps
uniform float u_noise_width;  // pixels
uniform float u_radius;       // scene units
uniform vec2 u_thickness;     // of slabs, in radii: constant part, and share of the way to the next tap
uniform float u_max_radius;   // pixels
uniform vec2 u_next_slice;    // (cos, sin) of the angle between slices

// What all taps of a slice have in common.
struct SsaoSweep {
    SsaoSlice slice;
    vec3 p;
    vec3 v;
    vec2 reach;  // pixels, along the slice
    vec2 least;  // a step of one pixel
    float offset;
};

// The bits that one texel hides: what lies within the radius, and behind it as far as the slab is thick.
uint ssao_texel(SsaoSweep w, vec2 at, float side, float thickness) {
    vec2 tap = (floor(at) + 0.5) * u_texel;
    float z = SAMPLE(u_z, tap).r;
    vec3 d = (ssao_position(tap, z) - w.p) / u_radius;
    vec2 front = ssao_into_slice(w.slice, d, w.v);
    // Over one radius all rays of sight are as good as parallel: the slab reaches straight away from the viewer.
    float near = ssao_u(w.slice, front, side);
    float far = ssao_u(w.slice, front - vec2(0.0, thickness), side);
    bool counts = z > 0.0 && dot(d, d) < 1.0 && front.x * side > 0.0 && tap == clamp(tap, vec2(0.0), vec2(1.0));
    return counts ? ssao_bits(min(near, far), max(near, far)) : 0u;
}

// Step k to both sides. Taps crowd near the pixel (power 3/2); a slab is thicker where the next tap is farther away.
uint ssao_step(SsaoSweep w, float k) {
    vec2 q = (vec2(k, k + 1.0) + w.offset) / float(STEPS);
    vec2 t = q * sqrt(q);
    vec2 way = w.reach * t.x + w.least;
    float thickness = u_thickness.x + u_thickness.y * (t.y - t.x);
    return ssao_texel(w, gl_FragCoord.xy + way, 1.0, thickness) | ssao_texel(w, gl_FragCoord.xy - way, -1.0, thickness);
}

// (visibility, 1) of the slice in direction turn, by its weight.
vec2 ssao_sweep(vec3 p, vec3 v, vec3 n, vec2 turn, float offset) {
    vec3 along = ssao_along(v, turn);
    vec2 texels = ssao_texels(p, along) * (u_radius / ssao_w(-p.z));
    float pixels = max(length(texels), 1e-6);
    vec2 direction = texels / pixels;
    SsaoSweep w = SsaoSweep(ssao_slice(along, v, n), p, v, direction * min(pixels, u_max_radius), direction, offset);
    uint bits = 0u;
#repeat STEPS bits |= ssao_step(w, float(@));
    return vec2(1.0 - ssao_count(bits) / 32.0, 1.0) * w.slice.weight;
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, max(z, 1e-30));
    vec3 v = ssao_to_viewer(p);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec4 noise = SAMPLE(u_noise, gl_FragCoord.xy / u_noise_width);
    vec2 turn = noise.xy;
    vec2 sum = vec2(0.0);
#repeat SLICES sum += ssao_sweep(p, v, n, turn, noise.z); turn = mat2(u_next_slice, -u_next_slice.y, u_next_slice.x) * turn;
    ssao_write(sum.x / max(sum.y, 1e-6), z);
}
