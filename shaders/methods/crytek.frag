// Crytek's SSAO: Mittring, "Finding Next Gen: CryEngine 2", SIGGRAPH 2007 course. Depth alone, no normals.
#include "lib/view.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_planes;       // unit normals to reflect at
uniform vec3 u_points[SAMPLES];   // of the unit ball
uniform float u_gain;

// Visibility of the point at p + offset. Of one outside the image nothing is known, and little of one behind something
// far before p: such points count as on a plane.
float ssao_point(vec2 uv, vec3 p, vec3 offset, float reach) {
    vec3 s = p + offset * reach;
    vec2 tap = ssao_middle(ssao_project(s, uv));
    float z = SAMPLE(u_z, tap).r;
    float known = 1.0 - clamp((-p.z - z) / reach - 1.0, 0.0, 1.0);
    float open = z > 0.0 ? mix(0.5, step(-s.z, z), known) : 1.0;
    return ssao_inside(tap) ? open : 0.5;
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z);
    float reach = ssao_reach(z);
    vec3 plane = SAMPLE(u_planes, gl_FragCoord.xy / u_noise_width).xyz;
    float sum = 0.0;
#repeat SAMPLES sum += ssao_point(uv, p, reflect(u_points[@], plane), reach);
    ssao_write(u_gain * sum / float(SAMPLES), z);
}
