// One axis of a joint bilateral filter: taps weigh by how well they lie in the tangent plane of the pixel.
// Along the axis, n . P is (a + i b) z + i d with constants of the pixel: no position is rebuilt for a tap.
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"

uniform sampler2D u_packed;   // visibility and linear depth
uniform sampler2D u_normal;
uniform vec2 u_step;          // uv of one texel along the axis
uniform float u_weights[RADIUS + 1];
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    vec2 here = ssao_unpack(SAMPLE(u_packed, uv).r);
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    float a = dot(n.xy, u_ray * uv + u_ray0) - n.z;
    float b = dot(n.xy, u_ray * u_step);
#ifdef PINHOLE
    float d = 0.0;
#else
    float d = dot(n.xy, u_org * u_step);
#endif
    float per_pixel = u_per_pixel / max(ssao_w(here.y), 1e-30);
    a *= per_pixel;
    b *= per_pixel;
    d *= per_pixel;
    float plane = a * here.y;
    vec2 sum = vec2(here.x, 1.0) * u_weights[0];
    vec2 tap;
    float weight;
    // background (depth 0) weighs nothing, on either side
#define TAP(I, SIDE) \
    tap = ssao_unpack(SAMPLE(u_packed, uv + float(SIDE) * u_step).r); \
    weight = clamp(2.0 - abs((a + float(SIDE) * b) * tap.y + float(SIDE) * d - plane), 0.0, 1.0) * u_weights[I]; \
    sum += tap.y > 0.0 ? vec2(tap.x, 1.0) * weight : vec2(0.0);
#repeat RADIUS TAP(@ + 1, @ + 1) TAP(@ + 1, -(@ + 1))
    float visibility = sum.x / sum.y;
#ifdef LAST
    frag_color = vec4(here.y > 0.0 ? visibility : 1.0);
#else
    frag_color = vec4(ssao_pack(visibility, here.y));
#endif
}
