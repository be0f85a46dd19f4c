// Volumetric obscurance by line samples: Loos, Sloan, "Volumetric Obscurance", I3D 2010. Lengths in units of the radius.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_rotation;
uniform vec3 u_lines[PAIRS];  // offset in the unit disk, and half the line's length in the unit sphere

// (filled, whole) length of a line of half length h, above the tangent plane; (0, -1) where nothing is known of it: outside the
// image, and behind what lies more than a radius before the sphere's middle and before the plane.
vec2 ssao_line(vec2 uv, float h, vec3 p, vec4 n, float reach) {
    vec2 tap = ssao_middle(uv);
    float z = SAMPLE(u_z, tap).r;
    // Two radii before or behind the middle stand for all that is farther: the tangent plane is met by the same ray.
    float depth = clamp(z > 0.0 ? z : 3e38, -p.z - 2.0 * reach, -p.z + 2.0 * reach);
    vec3 v = (ssao_position(tap, depth) - p) / reach;
    // Normals are stored in half floats: a plane must not rise above itself by their rounding.
    float above = (dot(v, n.xyz) - 1e-3 * length(v)) * n.w;
    float plane = clamp(v.z - above, -h, h);
    float surface = clamp(v.z, -h, h);
    bool hidden = min(v.z, above) > 1.0;
    return ssao_inside(tap) && !hidden ? vec2(max(surface - plane, 0.0), h - plane) : vec2(0.0, -1.0);
}

// Two lines opposite each other; one of which nothing is known takes after its partner.
vec2 ssao_pair(vec2 uv, vec2 offset, float h, vec3 p, vec4 n, float reach) {
    vec2 a = ssao_line(uv + offset, h, p, n, reach);
    vec2 b = ssao_line(uv - offset, h, p, n, reach);
    return max((a.y < 0.0 ? b : a) + (b.y < 0.0 ? a : b), 0.0);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z > 0.0 ? z : 1.0);
    vec3 v = ssao_to_viewer(p);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec4 normal = vec4(n, v.z / max(dot(n, v), 0.02));  // heights above the plane to depths before it
    float reach = ssao_reach(-p.z);
    mat2 disk = u_uv_per_unit * (reach / max(ssao_w(-p.z), 1e-30));
    vec2 turn = SAMPLE(u_rotation, gl_FragCoord.xy / u_noise_width).xy;
    vec2 sum = vec2(0.0);
#repeat PAIRS sum += ssao_pair(uv, disk * reflect(u_lines[@].xy, turn), u_lines[@].z, p, normal, reach);
    ssao_write(1.0 - sum.x / max(sum.y, 1e-6), z);
}
