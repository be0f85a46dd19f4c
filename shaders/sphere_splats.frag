// How much of a pixel's hemisphere a sphere hides to rays that go beyond the near range and end at the radius: -log(1 - share), so
// that sums are products of what spheres leave open. After Shanmugam, Arikan, "Hardware Accelerated Ambient Occlusion Techniques on
// GPUs", I3D 2007, with the share in closed form.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/taps.glsl"
#include "lib/near_range.glsl"
#include "lib/cap_factor.glsl"

uniform float u_per_radius;  // 1 / radius, scene units; u_radius is that of the near range
uniform vec2 u_bias;         // how far receivers are lifted: in radii, and of their distance

flat VARYING vec4 v_ball;
flat VARYING vec3 v_facing;

void main() {
    SsaoPixel pixel = ssao_pixel();
    if (pixel.z <= 0.0) discard;
    vec3 p = ssao_position(pixel.at * u_texel, pixel.z);
    float near = ssao_near_range(pixel.z) * u_per_radius;
    float distance_bias = u_bias.y * (abs(p.x) + abs(p.y) - p.z) * u_per_radius;
    p = p * u_per_radius + pixel.n * (u_bias.x + distance_bias);
    vec3 way = v_ball.xyz - p;
    float r = v_ball.w;
    if (max(abs(way.x), max(abs(way.y), abs(way.z))) >= 1.0 + r) discard;
    float d = length(way);
    float u = dot(way, pixel.n) / max(d, 1e-30);
    float far_cone = ssao_cone(d, r, 1.0), near_cone = near > 0.0 ? ssao_cone(d, r, near) : 0.0;
    float faces = abs(dot(way, v_facing)) / max(d, 1e-30);
    bool patch_of = dot(v_facing, v_facing) > 0.5;
    // A patch lies in its surface, which does not hide itself: it counts by its middle.
    float share = patch_of ? faces * (far_cone - near_cone) * max(u, 0.0) : ssao_cone_factor(far_cone, u) - ssao_cone_factor(near_cone, u);
    if (patch_of) share *= clamp(2.0 - 2.0 * r, 0.0, 1.0);  // patches wider than the radius do not know where they are
    share = clamp(share, 0.0, 0.9999);
    if (share < 1e-6) discard;
    frag_color = vec4(share < 0.01 ? share * (1.0 + share * (0.5 + share * 0.33333333)) : -log(1.0 - share));
}
