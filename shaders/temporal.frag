// Visibility averaged over frames: the four texels of the last frame around where the pixel was then, as far as they lie in its
// plane (reprojection by depth and pose; Nehab et al., "Accelerating Real-Time Shading with Reverse Reprojection Caching", 2007),
// and this frame's with the weight of one frame among all that count. Where nothing fits the pixel begins anew.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
uniform sampler2D u_now;
uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_history;     // visibility, number of frames, linear depth; 0 where there is none
uniform mat4 u_to_previous;      // from view space to the clip space of the last frame
uniform vec4 u_previous_depth;   // linear depth in the last frame = dot with a point in view space and 1
uniform float u_per_pixel;       // 1 / (tolerance in pixels * size of a pixel at w = 1)
uniform float u_most;            // frames that count
layout(location = 0) out vec4 out_open;
layout(location = 1) out vec4 out_history;

// A point in the last frame, and its plane.
struct SsaoThen {
    vec2 uv;
    float nearer;  // linear depth then, less that of now
    vec3 n;
    float here;    // n . P
    float scale;   // of distances off the plane
};

// Add the texel at a place of the last frame: its visibility, frames and weight.
void ssao_add(inout vec3 sum, SsaoThen then, vec2 uv, vec2 place, float z, float weight) {
    vec3 kept = SAMPLE(u_history, place).xyz;
    // The plane, seen as far aside as the texel lies from the point.
    vec2 there = uv + place - then.uv;
    float here = then.here, along = dot(then.n, vec3(u_ray * there + u_ray0, -1.0));
#ifndef PINHOLE
    here -= dot(then.n.xy, u_org * there + u_org0);
#endif
    float plane = abs(along) > 1e-6 ? here / along : z;
    float off = abs(kept.z - then.nearer - plane) * abs(along) * then.scale;
    bool inside = max(abs(place.x - 0.5), abs(place.y - 0.5)) < 0.5;
    float fits = inside && kept.z > 0.0 && off < 2.0 ? clamp(2.0 - off, 0.0, 1.0) : 0.0;
    sum += vec3(kept.xy, 1.0) * (fits * weight);
}

// What the last frames have of a point: visibility, and how many they are.
vec2 ssao_before(vec2 uv, vec3 p) {
    vec4 clip = u_to_previous * vec4(p, 1.0);
    if (!(clip.w > 0.0)) return vec2(1.0, 0.0);
    SsaoThen then;
    then.uv = 0.5 + 0.5 * clip.xy / clip.w;
    then.nearer = dot(u_previous_depth, vec4(p, 1.0)) + p.z;
    then.n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    then.here = dot(then.n, p);
    then.scale = u_per_pixel / max(ssao_w(-p.z), 1e-30);
    vec2 at = clamp(then.uv, -1.0, 2.0) * u_size - 0.5;
    vec2 corner = floor(at + 0.002);  // what did not move is itself
    vec2 f = clamp(at - corner, 0.0, 1.0) * step(0.002, at - corner), place = (corner + 0.5) * u_texel;
    vec3 sum = vec3(0.0);
    ssao_add(sum, then, uv, place, -p.z, (1.0 - f.x) * (1.0 - f.y));
    ssao_add(sum, then, uv, place + vec2(u_texel.x, 0.0), -p.z, f.x * (1.0 - f.y));
    ssao_add(sum, then, uv, place + vec2(0.0, u_texel.y), -p.z, (1.0 - f.x) * f.y);
    ssao_add(sum, then, uv, place + u_texel, -p.z, f.x * f.y);
    return sum.z > 0.05 ? sum.xy / sum.z : vec2(1.0, 0.0);
}

#ifdef MOVED
// The visibility nearest to v of those that this frame has around a pixel.
float ssao_within(float v, vec2 uv) {
    float low = 1.0, high = 0.0;
    for (int i = 0; i < 9; ++i) {
        float open = SAMPLE(u_now, uv + (vec2(float(i % 3), float(i / 3)) - 1.0) * u_texel).r;
        low = min(low, open);
        high = max(high, open);
    }
    return clamp(v, low, high);
}
#endif

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r, now = SAMPLE(u_now, uv).r;
    vec2 before = ssao_before(uv, ssao_position(uv, z));
#ifdef MOVED
    before.x = ssao_within(before.x, uv);
#endif
    float frames = clamp(before.y, 0.0, u_most - 1.0) + 1.0;
    float open = z > 0.0 ? mix(before.x, now, 1.0 / frames) : 1.0;
    out_open = vec4(open);
    out_history = z > 0.0 ? vec4(open, frames, z, 0.0) : vec4(0.0);
}
