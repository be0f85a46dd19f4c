// Alchemy ambient obscurance: McGuire, Osman, Bukowski, Hennessy, "The Alchemy Screen-Space Ambient Obscurance
// Algorithm", HPG 2011, equation 10. Lengths are in units of the radius, so any scene unit will do.
#include "lib/precision.glsl"
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_rotation;
uniform vec2 u_samples[SAMPLES];
uniform float u_radius;         // scene units
uniform float u_bias;           // of the distance to the eye
uniform float u_strength;       // 2 sigma / radius
uniform float u_power;
uniform float u_max_radius;     // pixels
uniform float u_rotation_width; // pixels

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec3 p = ssao_position(uv, z);
    LOW vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec2 turn = SAMPLE(u_rotation, gl_FragCoord.xy / u_rotation_width).xy;
    // The disk of the radius around p, parallel to the image; clamped to a size in pixels that taps can still cover.
    mat2 disk = u_uv_per_unit * (u_radius / max(ssao_w(z), 1e-30));
    vec2 extent = (abs(disk[0]) + abs(disk[1])) * u_size;
    float share = min(1.0, u_max_radius / max(max(extent.x, extent.y), 1e-6));
    disk *= share;
    float reach = max(u_radius * share, 1e-30);  // of the clamped disk: else nearer taps would weigh more
    float bias = u_bias * ssao_w(z) / reach;
    float sum = 0.0;
    LOW float count = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        // On texel centres: depth is that of the centre, and a point off it would leave the surface.
        vec2 tap = (floor((uv + disk * reflect(u_samples[i], turn)) * u_size) + 0.5) * u_texel;
        float z_q = SAMPLE(u_z, tap).r;
        // So many radii away nothing counts, and squares must not overflow.
        vec3 v = clamp(ssao_position(tap, z_q) - p, -1e15 * reach, 1e15 * reach) / reach;
        LOW float inside = tap == clamp(tap, vec2(0.0), vec2(1.0)) ? 1.0 : 0.0;
        // Background occludes nothing; a tap outside the image knows nothing and does not count.
        LOW float weight = z_q > 0.0 ? inside * max(0.0, dot(v, n) - bias) / (dot(v, v) + 1e-4) : 0.0;
        sum += weight;
        count += inside;
    }
    LOW float open = max(0.0, 1.0 - u_strength * sum / max(count, 1.0));
    ssao_write(u_power == 1.0 ? open : pow(max(open, 1e-6), u_power), z);
}
