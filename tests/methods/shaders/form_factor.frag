// What a parallelogram, as two triangles, hides of points on the floor y = 0: x and z from -1 to 1 over the target.
#include "lib/form_factor.glsl"
uniform vec2 u_texel;
uniform vec3 u_corner;
uniform vec3 u_right;
uniform vec3 u_up;

void main() {
    vec2 at = 2.0 * gl_FragCoord.xy * u_texel - 1.0;
    vec3 a = u_corner - vec3(at.x, 0.0, at.y), b = a + u_right, c = b + u_up, d = a + u_up, n = vec3(0.0, 1.0, 0.0);
    frag_color = vec4(ssao_triangle_form_factor(a, b, c, n) + ssao_triangle_form_factor(a, c, d, n));
}
