// Scalable ambient obscurance: McGuire, Mara, Luebke, "Scalable Ambient Obscurance", HPG 2012. Lengths in units of the radius.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_rotation;
uniform vec2 u_spiral[SAMPLES];
uniform float u_bias;      // radii
uniform float u_strength;  // 5 sigma / radius

// (obscurance, 1) by what is seen at uv; a tap outside the image knows nothing, background obscures nothing.
vec2 ssao_tap(vec2 uv, vec3 p, vec3 n, float reach) {
    vec2 tap = ssao_middle(uv);
    if (!ssao_inside(tap)) return vec2(0.0);
    float z = SAMPLE(u_z, tap).r;
    vec3 v = ssao_offset(tap, z, p, reach);
    float vv = dot(v, v);
    float f = max(1.0 - vv, 0.0);
    return vec2(z > 0.0 ? f * f * f * max(dot(v, n) - u_bias, 0.0) / (vv + 0.01) : 0.0, 1.0);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    float reach = ssao_reach(z);
    mat2 disk = u_uv_per_unit * (reach / max(ssao_w(z), 1e-30));
    vec2 turn = SAMPLE(u_rotation, gl_FragCoord.xy / u_noise_width).xy;
    vec2 sum = vec2(0.0);
#repeat SAMPLES sum += ssao_tap(uv + disk * reflect(u_spiral[@], turn), p, n, reach);
    ssao_write(1.0 - u_strength * sum.x / max(sum.y, 1.0), z);
}
