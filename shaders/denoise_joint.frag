// One axis of a joint bilateral filter: taps weigh by how well they lie in the tangent plane of the pixel.
// Along the axis, n . P is (a + i b) z + i d with a, b, d constant for the pixel: no position is rebuilt for a tap.
//
// NARROW: where not all taps lie in the plane, at creases and edges, visibility is steep, and a wide filter flattens it. There
// the taps up to NARROW count alone; their part of the noise tile is stratified in itself.
#needs es300
#include "lib/precision.glsl"
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/accumulate.glsl"

uniform sampler2D u_packed;   // visibility and linear depth
uniform sampler2D u_normal;
#ifdef BENT
uniform sampler2D u_lost;
#endif
#ifdef BOUNCE
uniform sampler2D u_gained;
#endif
uniform vec2 u_target_texel;  // 1 / size of the target
uniform vec2 u_target_uv;     // uv of the image for each fragment of the target
uniform vec2 u_next;          // one texel along the axis: of the target,
uniform vec2 u_step;          // and as uv of the image
uniform LOW float u_weights[RADIUS + 1];
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)

// What the taps sum up to.
struct SsaoTaps {
    SsaoSum sum;
#ifdef NARROW
    SsaoSum narrow;
    LOW float least;  // of how well they lie in the plane
#endif
};

// Add a tap i texels along the axis. Background (depth 0) weighs nothing.
// line is (a, b, d) and plane the plane's own distance, both in units of the tolerance.
void ssao_tap(inout SsaoTaps taps, vec2 uv, float i, vec3 line, float plane) {
    vec2 place = uv + i * u_next;
    vec2 tap = ssao_unpack(SAMPLE(u_packed, place).r);
    float off = abs((line.x + i * line.y) * tap.y + i * line.z - plane);
    LOW float fits = tap.y > 0.0 ? clamp(2.0 - off, 0.0, 1.0) : 0.0;
    LOW float weight = fits * u_weights[int(abs(i))];
    taps.sum.open += vec2(tap.x, 1.0) * weight;
#ifdef BENT
    vec3 lost = SAMPLE(u_lost, place).xyz;
    taps.sum.lost += lost * weight;
#endif
#ifdef BOUNCE
    vec4 gained = SAMPLE(u_gained, place);
    taps.sum.gained += gained * weight;
#endif
#ifdef NARROW
    taps.least = min(taps.least, fits);
    if (abs(i) > float(NARROW)) return;
    weight = abs(i) < float(NARROW) ? fits : 0.5 * fits;  // as of a tile 2 NARROW wide
    taps.narrow.open += vec2(tap.x, 1.0) * weight;
#ifdef BENT
    taps.narrow.lost += lost * weight;
#endif
#ifdef BOUNCE
    taps.narrow.gained += gained * weight;
#endif
#endif
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
    SsaoTaps taps;
    taps.sum = ssao_nothing();
    taps.sum.open = vec2(here.x, 1.0) * u_weights[0];
#ifdef BENT
    taps.sum.lost = SAMPLE(u_lost, uv).xyz * u_weights[0];
#endif
#ifdef BOUNCE
    taps.sum.gained = SAMPLE(u_gained, uv) * u_weights[0];
#endif
#ifdef NARROW
    taps.narrow = taps.sum;
    taps.least = 1.0;
#endif
#repeat RADIUS ssao_tap(taps, uv, float(@ + 1), line, plane); ssao_tap(taps, uv, -float(@ + 1), line, plane);
    SsaoSum sum = taps.sum;
#ifdef NARROW
    LOW float flat_enough = min(2.0 * taps.least, 1.0);  // rounding of steep planes does not count
    sum.open = mix(taps.narrow.open, sum.open, flat_enough);
#ifdef BENT
    sum.lost = mix(taps.narrow.lost, sum.lost, flat_enough);
#endif
#ifdef BOUNCE
    sum.gained = mix(taps.narrow.gained, sum.gained, flat_enough);
#endif
#endif
    float visibility = sum.open.x / sum.open.y;
#ifdef LAST
    frag_color = vec4(here.y > 0.0 ? visibility : 1.0);
#else
    frag_color = vec4(ssao_pack(visibility, here.y));
#endif
#ifdef BENT
    ssao_write_bent(sum.lost / sum.open.y, n);
#endif
#ifdef BOUNCE
    ssao_write_gained(sum.gained / sum.open.y);
#endif
}
