// Horizon-based ambient occlusion: Bavoil, Sainz, Dimitrov, "Image-Space Horizon-Based Ambient Occlusion", SIGGRAPH 2008 talks.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/slice.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_noise;  // (cos, sin) of the first direction, place of the taps between their steps
uniform vec2 u_next;        // (cos, sin) of the angle between directions
uniform vec2 u_bias;        // (cos, sin) of the angle above the tangent plane
uniform float u_strength;   // of a direction

// (sine of the horizon, occlusion) after the tap some pixels away: what rises above the horizon adds the arc between.
vec2 ssao_raise(vec2 horizon, SsaoSlice s, vec3 p, vec3 v, float reach, vec2 way) {
    vec2 tap = (floor(gl_FragCoord.xy + way) + 0.5) * u_texel;
    float z = SAMPLE(u_z, tap).r;
    vec3 d = ssao_offset(tap, z, p, reach);
    vec2 front = ssao_into_slice(s, d, v);
    float height = front.y * inversesqrt(max(dot(front, front), 1e-30));
    float weight = 1.0 - dot(d, d);
    bool counts = z > 0.0 && weight > 0.0 && front.x > 0.0 && ssao_inside(tap) && height > horizon.x;
    return counts ? vec2(height, horizon.y + weight * (height - horizon.x)) : horizon;
}

// Occlusion in direction turn.
float ssao_direction(vec3 p, vec3 v, vec3 n, vec2 turn, float place, float reach) {
    vec3 along = ssao_along(v, turn);
    vec2 texels = ssao_texels(p, along) * (reach / ssao_w(-p.z));
    float pixels = max(length(texels), 1e-6);
    vec2 direction = texels / pixels;
    SsaoSlice s = ssao_slice(along, v, n);
    // Sine and cosine of the tangent's elevation, and of the horizon's start.
    vec2 tangent = vec2(-s.normal.x, max(s.normal.y, 0.0));
    float start = tangent.y * u_bias.x > tangent.x * u_bias.y ? dot(tangent, u_bias) : 1.0;
    vec2 horizon = vec2(start, 0.0);
    float way = pixels * place / float(STEPS);
#repeat STEPS horizon = ssao_raise(horizon, s, p, v, reach, direction * max(way, 1.0)); way += pixels / float(STEPS);
    return horizon.y;
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z > 0.0 ? z : 1.0);
    vec3 v = ssao_to_viewer(p);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec4 noise = SAMPLE(u_noise, gl_FragCoord.xy / u_noise_width);
    float reach = ssao_reach(-p.z);
    mat2 next = mat2(u_next, -u_next.y, u_next.x);
    vec2 turn = noise.xy;
    float sum = 0.0;
#repeat DIRECTIONS sum += ssao_direction(p, v, n, turn, noise.z, reach); turn = next * turn;
    ssao_write(1.0 - u_strength * sum, z);
}
