// The space that a sphere may darken, one instance each: a box, along the axes of the view, about the sphere and all that is nearer
// to it than the radius. Its back faces alone are drawn, each pixel once, wherever the eye is.
#needs es300
#include "lib/box_strip.glsl"

uniform mat4 u_view;
uniform mat4 u_projection;
uniform float u_volume_radius;  // scene units
uniform float u_per_radius;     // 1 / u_volume_radius
uniform float u_texel_reach;    // a texel of the target, scene units per unit of clip w
uniform vec2 u_w;

ATTRIBUTE vec4 a_ball;    // centre and radius
ATTRIBUTE vec3 a_facing;  // unit normal of a patch; 0 of a true sphere

// View space; the ball in radii.
flat VARYING vec4 v_ball;
flat VARYING vec3 v_facing;

void main() {
    vec3 middle = (u_view * vec4(a_ball.xyz, 1.0)).xyz;
    float more = a_ball.w + u_volume_radius;
    // A texel wider, since what it shows lies beside its middle.
    more += u_texel_reach * abs(u_w.x * (more - middle.z) + u_w.y);
    gl_Position = u_projection * vec4(middle + more * (2.0 * ssao_box_corner() - 1.0), 1.0);
    gl_Position.z = 0.0;  // nothing is cut off before the near or behind the far plane
    v_ball = vec4(middle, a_ball.w) * u_per_radius;
    v_facing = mat3(u_view) * a_facing;
}
