// One axis of the joint filter of residuals: weighted sums over the texels in the tangent plane whose normals are alike. As in
// denoise_joint.frag, n . P is (a + i b) z + i d along the axis.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/residual.glsl"

uniform sampler2D u_residual;
uniform vec2 u_target_texel;  // 1 / size of the target
uniform vec2 u_target_uv;     // uv of the image for each fragment of the target
uniform vec2 u_next;          // one texel along the axis: of the target,
uniform vec2 u_step;          // and as uv of the image
uniform float u_weights[RADIUS + 1];
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)

vec2 ssao_tap(vec2 uv, float i, float weight, vec3 line, float plane, vec2 normal) {
    vec4 tap = SAMPLE(u_residual, uv + i * u_next);
    float off = abs((line.x + i * line.y) * tap.z + i * line.z - plane);
    float fits = tap.z > 0.0 ? clamp(2.0 - off, 0.0, 1.0) : 0.0;
    return tap.xy * (fits * ssao_alike(ssao_unpack_normal(tap.w), normal) * weight);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_target_texel;
    vec4 here = SAMPLE(u_residual, uv);
    vec2 normal = ssao_unpack_normal(here.w);
    vec3 n = ssao_decode_normal(normal);
    vec3 line = vec3(dot(n.xy, u_ray * (gl_FragCoord.xy * u_target_uv) + u_ray0) - n.z, dot(n.xy, u_ray * u_step), 0.0);
#ifndef PINHOLE
    line.z = dot(n.xy, u_org * u_step);
#endif
    line *= u_per_pixel / max(ssao_w(here.z), 1e-30);
    float plane = line.x * here.z;
    vec2 sum = here.xy * u_weights[0];
#repeat RADIUS sum += ssao_tap(uv, float(@ + 1), u_weights[@ + 1], line, plane, normal) + ssao_tap(uv, -float(@ + 1), u_weights[@ + 1], line, plane, normal);
    frag_color = vec4(here.z > 0.0 ? sum : vec2(0.0), here.zw);
}
