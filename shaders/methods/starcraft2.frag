// StarCraft II's SSAO: Filion, McNaughton, "StarCraft II: Effects and Techniques", SIGGRAPH 2008 course.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_planes;      // unit normals to reflect at
uniform vec3 u_points[SAMPLES];  // of the unit ball
uniform float u_ratio;           // of each radius to the one before
uniform vec3 u_curve;            // full occlusion up to x radii; falls over 1 / y from there; power z
uniform float u_bias;            // sine of an angle

// Occlusion by a surface that lies x radii before the sample.
float ssao_curve(float x) {
    float fall = clamp((x - u_curve.x) * u_curve.y, 0.0, 1.0);
    return x > 0.0 ? 1.0 - (u_curve.z == 1.0 ? fall : pow(max(fall, 1e-6), u_curve.z)) : 0.0;
}

// (occlusion, 1) of the point at p + offset; one outside the image knows nothing, background occludes nothing.
vec2 ssao_point(vec2 uv, vec3 p, vec3 n, vec3 offset, float reach) {
    vec3 s = p + (dot(offset, n) < 0.0 ? -offset : offset) * reach;
    vec2 tap = ssao_middle(ssao_project(s, uv));
    if (!ssao_inside(tap)) return vec2(0.0);
    float z = SAMPLE(u_z, tap).r;
    vec3 v = (ssao_position(tap, z) - p) / reach;
    bool rises = dot(v, n) > u_bias * length(v);
    return vec2(z > 0.0 && rises ? ssao_curve((-s.z - z) / reach) : 0.0, 1.0);
}

// Occlusion within one radius.
float ssao_layer(vec2 uv, vec3 p, vec3 n, vec3 plane, float reach) {
    vec2 sum = vec2(0.0);
#repeat SAMPLES sum += ssao_point(uv, p, n, reflect(u_points[@], plane), reach);
    return sum.x / max(sum.y, 1.0);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec3 plane = SAMPLE(u_planes, gl_FragCoord.xy / u_noise_width).xyz;
    float reach = ssao_reach(z);
    float occlusion = 0.0;
#repeat RADII occlusion = max(occlusion, ssao_layer(uv, p, n, plane, reach)); reach *= u_ratio;
    ssao_write(1.0 - occlusion, z);
}
