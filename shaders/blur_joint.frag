// One axis of a joint bilateral filter: taps weigh by how well they lie in the tangent plane of the pixel.
// Along the axis, n . P is (a + i b) z + i d with a, b, d constant for the pixel: no position is rebuilt for a tap.
#needs es300
#include "lib/precision.glsl"
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"

uniform sampler2D u_packed;   // visibility and linear depth
uniform sampler2D u_normal;
uniform vec2 u_target_texel;  // 1 / size of the target
uniform vec2 u_target_uv;     // uv of the image for each fragment of the target
uniform vec2 u_next;          // one texel along the axis: of the target,
uniform vec2 u_step;          // and as uv of the image
uniform LOW float u_weights[RADIUS + 1];
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)

// A tap i texels along the axis: (visibility, 1) by its weight. Background (depth 0) weighs nothing.
// line is (a, b, d) and plane the plane's own distance, both in units of the tolerance.
vec2 ssao_tap(vec2 uv, float i, LOW float weight, vec3 line, float plane) {
    vec2 tap = ssao_unpack(SAMPLE(u_packed, uv + i * u_next).r);
    float off = abs((line.x + i * line.y) * tap.y + i * line.z - plane);
    LOW float fits = clamp(2.0 - off, 0.0, 1.0);
    return tap.y > 0.0 ? vec2(tap.x, 1.0) * (fits * weight) : vec2(0.0);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_target_texel;
    vec2 here = ssao_unpack(SAMPLE(u_packed, uv).r);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec3 line = vec3(dot(n.xy, u_ray * (floor(gl_FragCoord.xy) * u_target_uv + 0.5 * u_texel) + u_ray0) - n.z, dot(n.xy, u_ray * u_step), 0.0);
#ifndef PINHOLE
    line.z = dot(n.xy, u_org * u_step);
#endif
    line *= u_per_pixel / max(ssao_w(here.y), 1e-30);
    float plane = line.x * here.y;
    vec2 sum = vec2(here.x, 1.0) * u_weights[0];
#repeat RADIUS sum += ssao_tap(uv, float(@ + 1), u_weights[@ + 1], line, plane) + ssao_tap(uv, -float(@ + 1), u_weights[@ + 1], line, plane);
    float visibility = sum.x / sum.y;
#ifdef LAST
    frag_color = vec4(here.y > 0.0 ? visibility : 1.0);
#else
    frag_color = vec4(ssao_pack(visibility, here.y));
#endif
}
