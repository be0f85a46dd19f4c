// The space that a triangle may darken (its ambient occlusion volume: McGuire 2010), one instance each: a box about the triangle
// and all that is nearer to it than the radius, on its front or on both sides. The box is a strip of 14 corners, by the number of
// the vertex; its back faces alone are drawn, each pixel once, wherever the eye is.
#needs es300
#include "lib/box_strip.glsl"

uniform mat4 u_view;
uniform mat4 u_projection;
uniform float u_volume_radius;  // scene units
uniform float u_per_radius;  // 1 / u_volume_radius: dividing is not as exact everywhere
uniform float u_texel_reach;  // a texel of the target, scene units per unit of clip w
uniform vec2 u_w;

ATTRIBUTE vec3 a_first;
ATTRIBUTE vec3 a_second;
ATTRIBUTE vec3 a_third;
ATTRIBUTE float a_solid;  // share of the triangle that alpha leaves

// View space, in radii.
flat VARYING vec3 v_first;
flat VARYING vec3 v_second;
flat VARYING vec3 v_third;
flat VARYING float v_solid;

vec3 ssao_unit(vec3 v) {
    v /= max(max(abs(v.x), abs(v.y)), max(abs(v.z), 1e-37));
    return v * inversesqrt(max(dot(v, v), 1e-37));
}

void main() {
    v_first = (u_view * vec4(a_first, 1.0)).xyz;
    v_second = (u_view * vec4(a_second, 1.0)).xyz;
    v_third = (u_view * vec4(a_third, 1.0)).xyz;
    // Along the longest edge, across it, and up from the triangle.
    vec3 a = v_second - v_first, b = v_third - v_second, c = v_first - v_third;
    vec3 squares = vec3(dot(a, a), dot(b, b), dot(c, c));
    vec3 x = ssao_unit(squares.x >= max(squares.y, squares.z) ? a : squares.y >= squares.z ? b : c);
    vec3 up = ssao_unit(cross(ssao_unit(a), ssao_unit(-c)));
    vec3 y = cross(up, x);
    vec3 away = v_third - v_first;
    vec2 second = vec2(dot(a, x), dot(a, y)), third = vec2(dot(away, x), dot(away, y));
    vec2 low = min(min(second, third), vec2(0.0)), high = max(max(second, third), vec2(0.0));
    // A texel wider, since what it shows lies beside its middle.
    float farthest = max(-v_first.z, max(-v_second.z, -v_third.z)) + u_volume_radius;
    float more = u_volume_radius + u_texel_reach * abs(u_w.x * farthest + u_w.y);
    vec3 corner = ssao_box_corner();
    vec2 flat_place = mix(low - more, high + more, corner.xy);
#ifdef BOTH_SIDES
    float height = mix(-more, more, corner.z);
#else
    float height = mix(u_volume_radius - more, more, corner.z);
#endif
    gl_Position = u_projection * vec4(v_first + flat_place.x * x + flat_place.y * y + height * up, 1.0);
    gl_Position.z = 0.0;  // nothing is cut off before the near or behind the far plane
    v_solid = a_solid;
    v_first *= u_per_radius;
    v_second *= u_per_radius;
    v_third *= u_per_radius;
}
