// Near occlusion by the pixels around, each a sphere as large as what it stands for, times what far spheres leave open: Shanmugam,
// Arikan, "Hardware Accelerated Ambient Occlusion Techniques on GPUs", I3D 2007. Lengths in units of the near range.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"
#if SAMPLES > 0
#include "lib/near_range.glsl"
#endif

uniform sampler2D u_hidden;
uniform float u_strength;
#if SAMPLES > 0
uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_rotation;
uniform vec3 u_points[SAMPLES];  // offset in the unit disk, and the share of the disk that it stands for

// (hidden, 1) by what is seen at uv, (0, 0) outside the image. A pixel's surface is as large as its footprint, seen from aside more,
// and hides as much of it as it faces the receiver.
vec2 ssao_ball(vec2 uv, float share, vec3 p, vec3 n, float reach) {
    vec2 tap = ssao_middle(uv);
    if (!ssao_inside(tap)) return vec2(0.0);
    float z = SAMPLE(u_z, tap).r;
    vec3 way = ssao_offset(tap, z, p, reach);
    float square = max(dot(way, way), 1e-12);
    if (z <= 0.0 || square >= 1.0) return vec2(0.0, 1.0);
    float wider = ssao_w(z) / max(ssao_w(-p.z), 1e-30);
    float area = share * wider * wider;  // pi r^2 / pi
    vec3 m = ssao_decode_normal(SAMPLE(u_normal, tap).xy);
    area *= max(-dot(m, way), 0.0) * inversesqrt(square) / max(dot(m, ssao_to_viewer(p)), 0.1);
    float rise = dot(way, n) * inversesqrt(square) - 2e-3;  // normals are stored in half floats
    return vec2(area / (square + area) * max(rise, 0.0), 1.0);
}
#endif

void main() {
    SsaoPixel pixel = ssao_pixel();
    float open = exp(-u_strength * SAMPLE(u_hidden, gl_FragCoord.xy * u_target_texel).r);
#if SAMPLES > 0
    vec2 uv = pixel.at * u_texel;
    vec3 p = ssao_position(uv, pixel.z > 0.0 ? pixel.z : 1.0);
    float reach = max(ssao_near_range(-p.z), 1e-6 * u_radius);
    mat2 disk = u_uv_per_unit * (reach / max(ssao_w(-p.z), 1e-30));
    vec2 turn = SAMPLE(u_rotation, gl_FragCoord.xy / u_noise_width).xy;
    vec2 sum = vec2(0.0);
#repeat SAMPLES sum += ssao_ball(uv + disk * reflect(u_points[@].xy, turn), u_points[@].z, p, pixel.n, reach);
    open *= max(1.0 - u_strength * sum.x * float(SAMPLES) / max(sum.y, 1.0), 0.0);
#endif
    ssao_write(open, pixel.z);
}
