// Ground-truth ambient occlusion: the slice integral of Jimenez, Wu, Pesce, Jarabo, "Practical Realtime Strategies for Accurate
// Indirect Occlusion", SIGGRAPH 2016 course, sampled as XeGTAO does (see methods/gtao.py). Lengths in units of the radius.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/slice.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_noise;    // (cos, sin) of the first slice's direction, place of the taps between their steps
uniform vec2 u_next_slice;    // (cos, sin) of the angle between slices
uniform float u_per_falloff;  // 1 / the part of the radius over which occluders fade
uniform float u_thin;         // by which distances in depth are stretched
uniform float u_lift;         // of the slices' weights towards 1
uniform float u_power;

// What all taps of a slice have in common.
struct SsaoSweep {
    SsaoSlice slice;
    vec3 p;
    vec3 v;
    float reach;     // scene units
    vec2 direction;  // in the image
    float pixels;    // of the reach
    float noise;
};

// The cosine of a side's horizon after the tap at a pixel; far occluders fade to the hemisphere's edge.
float ssao_raise(float horizon, SsaoSweep w, vec2 pixel, float side) {
    vec2 tap = (floor(pixel) + 0.5) * u_texel;
    float z = SAMPLE(u_z, tap).r;
    vec3 d = ssao_offset(tap, z, w.p, w.reach);
    vec2 front = ssao_into_slice(w.slice, d, w.v);
    float height = front.y * inversesqrt(max(dot(front, front), 1e-30));
    float weight = clamp((1.0 - length(vec3(d.xy, d.z * u_thin))) * u_per_falloff, 0.0, 1.0);
    bool counts = z > 0.0 && front.x * side > 0.0 && ssao_inside(tap);
    return counts ? max(horizon, mix(-side * w.slice.normal.x, height, weight)) : horizon;
}

// Step k to both sides: (cosine of the + horizon, of the - horizon).
vec2 ssao_step(vec2 horizon, SsaoSweep w, float k, float slice) {
    float q = (k + fract(w.noise + (slice + k * float(STEPS)) * 0.6180339887)) / float(STEPS);
    vec2 way = w.direction * (q * q * w.pixels + 1.3);
    return vec2(
        ssao_raise(horizon.x, w, gl_FragCoord.xy + way, 1.0),
        ssao_raise(horizon.y, w, gl_FragCoord.xy - way, -1.0)
    );
}

// (cos g + 2 h sin g - cos(2 h - g)) / 4 for the horizon on one side whose cosine is c.
float ssao_arc(SsaoSlice s, float c, float side) {
    float h = ssao_acos(clamp(c, -1.0, 1.0));
    float sin2 = max(1.0 - c * c, 0.0);
    return 0.5 * (max(s.normal.y, 0.0) * sin2 + side * s.normal.x * (h - c * sqrt(sin2)));
}

// Visibility in the slice of direction turn, and what it is without occluders.
vec2 ssao_sweep(vec3 p, vec3 v, vec3 n, vec2 turn, float noise, float slice, float reach) {
    vec3 along = ssao_along(v, turn);
    vec2 texels = ssao_texels(p, along) * (reach / ssao_w(-p.z));
    float pixels = max(length(texels), 1e-6);
    SsaoSlice s = ssao_slice(along, v, n);
    SsaoSweep w = SsaoSweep(s, p, v, reach, texels / pixels, pixels, noise);
    vec2 horizon = vec2(-s.normal.x, s.normal.x);  // the edges of the hemisphere
#repeat STEPS horizon = ssao_step(horizon, w, float(@), slice);
    float weight = mix(length(vec2(dot(n, along), dot(n, v))), 1.0, u_lift);
    float fade = 0.5 * clamp((10.0 - pixels) * 0.01, 0.0, 1.0);
    float arcs = ssao_arc(s, horizon.x, 1.0) + ssao_arc(s, horizon.y, -1.0);
    return vec2(weight * arcs + fade * s.weight, s.weight);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z > 0.0 ? z : 1.0);
    vec3 v = ssao_to_viewer(p);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec4 noise = SAMPLE(u_noise, gl_FragCoord.xy / u_noise_width);
    float reach = ssao_reach(-p.z);
    mat2 next = mat2(u_next_slice, -u_next_slice.y, u_next_slice.x);
    vec2 turn = noise.xy;
    vec2 sum = vec2(0.0);
#repeat SLICES sum += ssao_sweep(p, v, n, turn, noise.z, float(@), reach); turn = next * turn;
    // In XeGTAO no pixel is quite black.
    ssao_write(max(0.03, pow(max(sum.x / max(sum.y, 1e-6), 1e-6), u_power)), z);
}
