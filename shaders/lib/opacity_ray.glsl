// A ray's light, front to back (Levoy 1988; Engel et al. 2006, "Real-Time Volume Graphics"): what takes it has a mean colour, and
// the surface lies where half of it is taken. What has no opacity is skipped; hardly any light left ends the march. The
// surface behind the first is that of the next material: the march waits for the first one to end.
#include "lib/srgb.glsl"
uniform sampler2D u_transfer;  // sRGB and opacity over the unit length, of values from 0 to 1
uniform mat3 u_place;          // voxels -> scene units, whatever way they are turned
uniform vec2 u_march;          // step in voxels, unit length of opacities in scene units

const float SSAO_SEEN = 0.5, SSAO_DARK = 0.02, SSAO_CLEAR = 0.01;
const float SSAO_FINER = 0.125;  // of the step in which the surface lies, so that there are no terraces

vec4 ssao_transfer(float value) {
    float steps = float(textureSize(u_transfer, 0).x - 1);
    float place = clamp(value, 0.0, 1.0) * steps, below = min(floor(place), steps - 1.0);
    return mix(texelFetch(u_transfer, ivec2(int(below), 0), 0), texelFetch(u_transfer, ivec2(int(below) + 1, 0), 0), place - below);
}

Seen ssao_trace(vec3 start, vec3 along, float s, float last) {
    vec3 inverse = 1.0 / along, forward = step(0.0, along);
    vec3 cell = clamp(floor(start + s * along), u_first, u_end - 1.0);
    float whole = u_march.x / length(along), unit = u_march.y / length(u_place * along), stride = whole, light = 1.0;
    Seen seen = Seen(false, last, cell, vec3(0.0));
#ifdef BEHIND
    bool waits = true;
#endif
    for (int i = 0; i < u_most; i++) {
        Leap leap = ssao_leap(cell);
        if (leap.one_sided) {
            float next;
            vec3 beyond = ssao_beyond(start, along, inverse, forward, leap, s, last, next);
            if (next >= last || ssao_left(beyond)) break;
            cell = beyond;
            s = next;
#ifdef BEHIND
            waits = false;
#endif
            continue;
        }
        float end = min((floor(s / stride) + 1.0) * stride, last);
        if (!(end > s)) end = min(s + stride, last);
        vec4 point = ssao_transfer(ssao_field(start + 0.5 * (s + end) * along));
#ifdef BEHIND
        waits = waits && point.a >= SSAO_CLEAR;
        if (waits) point.a = 0.0;
#endif
        float after = point.a > 0.0 ? light * pow(1.0 - point.a, (end - s) / unit) : light;
        if (!seen.found && after <= 1.0 - SSAO_SEEN) {
            if (stride == whole) {
                stride *= SSAO_FINER;
                continue;
            }
            float part = point.a < 1.0 ? unit * log((1.0 - SSAO_SEEN) / light) / log(1.0 - point.a) : 0.0;
            seen.s = s + clamp(part, 0.0, end - s);
            seen.found = true;
            stride = whole;
        }
#ifdef COLOR
        seen.color += (light - after) * ssao_srgb_to_linear(point.rgb);
#else
        if (seen.found) break;
#endif
        light = after;
        s = end;
        if (light <= SSAO_DARK || s >= last) break;
        cell = clamp(floor(start + s * along), u_first, u_end - 1.0);
    }
    seen.cell = ssao_cell_of(start + seen.s * along);
    seen.color = ssao_linear_to_srgb(seen.color / max(1.0 - light, 1e-6));
    return seen;
}
