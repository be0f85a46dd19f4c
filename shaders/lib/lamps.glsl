// Lamps without extent, and their shadows. LAMPS: how many there is room for.
#ifndef LAMPS
#define LAMPS 1
#endif
#ifdef SHADOWS
#include "lib/shadow.glsl"
uniform sampler2D u_geometric;  // the triangle's own normal
#endif

#if LAMPS > 0
uniform vec4 u_lamp_place[LAMPS];  // view space: a place and 1, or the direction to it and 0
uniform vec4 u_lamp_color[LAMPS];  // linear light, 1 / range^2
uniform vec4 u_lamp_axis[LAMPS];   // of a spot: how bright it is in direction d is clamp(w - dot(xyz, d), 0, 1)^2

// Light from lamp i at p, and the direction to it. glTF's KHR_lights_punctual: inverse square, windowed by the range.
vec3 ssao_lamp(int i, vec3 p, out vec3 to) {
    vec4 place = u_lamp_place[i], color = u_lamp_color[i], axis = u_lamp_axis[i];
    vec3 away = place.xyz - place.w * p;
    float distance2 = max(dot(away, away), 1e-30);
    to = away * inversesqrt(distance2);
    float reach = clamp(1.0 - distance2 * distance2 * color.w * color.w, 0.0, 1.0);
    float cone = clamp(axis.w - dot(axis.xyz, to), 0.0, 1.0);
    return color.rgb * mix(1.0, reach * cone * cone / distance2, place.w);
}

// How much of lamp 0 reaches a pixel.
float ssao_first_lamp(vec2 uv, vec3 p) {
#ifdef SHADOWS
    return u_lamp_place[0].w > 0.0 ? 1.0 : ssao_lit(p, ssao_decode_normal(SAMPLE(u_geometric, uv).xy), u_lamp_place[0].xyz);
#else
    return 1.0;
#endif
}

// What all lamps bring to a matt surface.
vec3 ssao_lamps(vec3 p, vec3 n, float first) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LAMPS; i++) {
        vec3 to;
        vec3 light = ssao_lamp(i, p, to);
        sum += light * (max(dot(n, to), 0.0) * (i == 0 ? first : 1.0));
    }
    return sum;
}
#endif
