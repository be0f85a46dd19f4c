// How much of a pixel's hemisphere a triangle hides, by how far from its volume's sides the pixel lies: added up over triangles.
// McGuire, "Ambient Occlusion Volumes", HPG 2010.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/form_factor.glsl"

uniform float u_per_radius;  // 1 / radius, scene units
uniform float u_power;  // of the falloff above the triangle
uniform vec2 u_bias;    // how far receivers are lifted: in radii, and of their distance

flat VARYING vec3 v_first;
flat VARYING vec3 v_second;
flat VARYING vec3 v_third;
flat VARYING float v_solid;

// 1 inside of an edge, 0 a radius beside it. up: the triangle's normal; a, b: the edge's ends, relative to the receiver.
float ssao_beside(vec3 a, vec3 b, vec3 up) {
    vec3 out_of = cross(b - a, up);
    return clamp(1.0 + dot(a, out_of) * inversesqrt(max(dot(out_of, out_of), 1e-37)), 0.0, 1.0);
}

const float LEVEL = 1e-3;  // sine of the elevation above which corners rise over the horizon

void main() {
    SsaoPixel pixel = ssao_pixel();
    if (pixel.z <= 0.0) discard;
    vec3 p = ssao_position(pixel.at * u_texel, pixel.z);
    float distance_bias = u_bias.y * (abs(p.x) + abs(p.y) - p.z) * u_per_radius;
    p = p * u_per_radius + pixel.n * (u_bias.x + distance_bias);
    vec3 a = v_first - p, b = v_second - p, c = v_third - p;
    vec3 up = cross(b - a, c - a);
    up *= inversesqrt(max(dot(up, up), 1e-37));
    float height = -dot(a, up);
#ifdef BOTH_SIDES
    height = abs(height);
#endif
    if (!(height > 0.0 && height < 1.0)) discard;
    // The receiver's own triangle, and what hides no millionth: interpolated depth leaves a plane by up to 1e-3 of its width.
    vec3 rise = vec3(dot(a, pixel.n), dot(b, pixel.n), dot(c, pixel.n)) - LEVEL * vec3(length(a), length(b), length(c));
    if (max(max(rise.x, rise.y), rise.z) <= 0.0) discard;
    float weight = ssao_beside(a, b, up) * ssao_beside(b, c, up) * ssao_beside(c, a, up) * pow(1.0 - height, u_power);
    if (weight <= 0.0) discard;
    frag_color = vec4(v_solid * weight * ssao_triangle_form_factor(a, b, c, pixel.n));
}
