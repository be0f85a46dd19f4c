// The slice of a normal that is turned from the viewer by an angle, positive along the slice: one angle a column.
#needs es300
#include "lib/view.glsl"
#include "lib/slice.glsl"
uniform float u_out;  // of the normal, at right angles to the slice
layout(location = 0) out vec4 out_weight;
layout(location = 1) out vec4 out_u0;
layout(location = 2) out vec4 out_lower;
layout(location = 3) out vec4 out_upper;

void main() {
    float angle = (gl_FragCoord.x * u_texel.x * 2.0 - 1.0) * SSAO_PI;
    vec3 n = vec3(sqrt(1.0 - u_out * u_out) * vec2(sin(angle), cos(angle)), u_out).xzy;
    SsaoSlice s = ssao_slice(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), n);
    float t = (gl_FragCoord.y * u_texel.y) * SSAO_PI;
    out_weight = vec4(s.weight);
    out_u0 = vec4(s.u0);
    out_lower = vec4(ssao_u(s, vec2(-sin(t), cos(t)), -1.0));
    out_upper = vec4(ssao_u(s, vec2(sin(t), cos(t)), 1.0));
}
