// Visibility averaged over frames: the four texels of the last frame around where the pixel was then, as far as they lie in its
// plane (reprojection by depth and pose; Nehab et al., "Accelerating Real-Time Shading with Reverse Reprojection Caching", 2007),
// and this frame's with the weight of one frame among all that count. Where nothing fits the pixel begins anew.
// SMALL: at the size at which occlusion is drawn, from packed texels; upsampling reads the history itself, which has all its digits.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/output.glsl"
uniform sampler2D u_now;
uniform sampler2D u_history;     // visibility, number of frames, linear depth; 0 where there is none
uniform mat4 u_to_previous;      // from view space to the clip space of the last frame
uniform vec4 u_previous_depth;   // linear depth in the last frame = dot with a point in view space and 1
uniform float u_per_pixel;       // 1 / (tolerance in pixels * size of a pixel at w = 1)
uniform float u_most;            // frames that count
layout(location = 0) out vec4 out_history;
#ifndef SMALL
layout(location = 1) out vec4 out_open;
#endif

// A point in the last frame, and its plane.
struct SsaoThen {
    vec2 at;       // where it is now less where it was then, uv
    float nearer;  // linear depth then, less that of now
    vec3 n;
    float here;    // n . P
    float scale;   // of distances off the plane
};

// Which of the pixels below a texel, by its depth (see lib/center_pixel.glsl): an offset from the first.
vec2 ssao_which(float z) {
#ifdef SMALL
    uint which = floatBitsToUint(z);
    return vec2(float(which & 3u), float((which >> 2u) & 3u));
#else
    return vec2(0.0);
#endif
}

// Visibility of this frame at a texel, and whether there is a surface.
vec2 ssao_now(vec2 texel) {
    float now = SAMPLE(u_now, (texel + 0.5) * u_target_texel).r;
#ifdef SMALL
    vec2 both = ssao_unpack(now);
    return vec2(both.x, both.y > 0.0 ? 1.0 : 0.0);
#else
    return vec2(now, 1.0);
#endif
}

// Add a texel of the last frame: its visibility, frames and weight, and how much of it hid the point.
void ssao_add(inout vec4 sum, SsaoThen then, vec2 texel, float z, float weight) {
    vec2 place = (texel + 0.5) * u_target_texel;
    vec3 kept = SAMPLE(u_history, place).xyz;
    // The plane, seen as far aside as the texel's pixel lies from the point.
    vec2 there = then.at + (texel * u_scale + ssao_which(kept.z) + 0.5) * u_texel;
    float here = then.here, along = dot(then.n, vec3(u_ray * there + u_ray0, -1.0));
#ifndef PINHOLE
    here -= dot(then.n.xy, u_org * there + u_org0);
#endif
    float plane = abs(along) > 1e-6 ? here / along : z;
    float behind = (kept.z - then.nearer - plane) * abs(along) * then.scale, off = abs(behind);
    bool inside = max(abs(place.x - 0.5), abs(place.y - 0.5)) < 0.5;
    float fits = inside && kept.z > 0.0 && off < 2.0 ? clamp(2.0 - off, 0.0, 1.0) : 0.0;
    sum += vec4(vec3(kept.xy, 1.0) * fits, kept.z > 0.0 && behind < -2.0 ? 1.0 : 0.0) * weight;
}

// What the last frames have of a pixel: visibility, and how many they are.
vec2 ssao_before(SsaoPixel pixel) {
    vec3 p = ssao_position(pixel.at * u_texel, pixel.z);
    vec4 clip = u_to_previous * vec4(p, 1.0);
    if (!(clip.w > 0.0)) return vec2(1.0, 0.0);
    vec2 uv = 0.5 + 0.5 * clip.xy / clip.w;
    SsaoThen then;
    then.at = pixel.at * u_texel - uv;
    then.nearer = dot(u_previous_depth, vec4(p, 1.0)) + p.z;
    then.n = pixel.n;
    then.here = dot(then.n, p);
    then.scale = u_per_pixel / max(ssao_w(pixel.z), 1e-30);
    // A texel moves as its pixel does, whichever of those below it that is.
    vec2 at = (clamp(uv, -1.0, 2.0) * u_size - 0.5 - ssao_which(pixel.z)) / u_scale;
    vec2 corner = floor(at + 0.002);  // what did not move is itself
    vec2 f = clamp(at - corner, 0.0, 1.0) * step(0.002, at - corner);
    vec4 sum = vec4(0.0);
    ssao_add(sum, then, corner, pixel.z, (1.0 - f.x) * (1.0 - f.y));
    ssao_add(sum, then, corner + vec2(1.0, 0.0), pixel.z, f.x * (1.0 - f.y));
    ssao_add(sum, then, corner + vec2(0.0, 1.0), pixel.z, (1.0 - f.x) * f.y);
    ssao_add(sum, then, corner + 1.0, pixel.z, f.x * f.y);
#if defined(SMALL) && !defined(MOVED)
    // At an edge few texels know the surface: all around have a say, the more the fewer these are, but where the point was hidden.
    if (sum.z < 0.98 && sum.w < 0.75) {
        vec2 middle = floor(at + 0.5);
        float each = sum.z < 0.75 ? 1.0 : 0.1;
        for (int i = 0; i < 9; ++i)
            ssao_add(sum, then, middle + vec2(float(i % 3), float(i / 3)) - 1.0, pixel.z, each);
    }
#endif
    return sum.z > 0.05 ? sum.xy / sum.z : vec2(1.0, 0.0);
}

#ifdef MOVED
// The visibility nearest to v of those that this frame has around a texel.
float ssao_within(float v, vec2 texel) {
    float low = 1.0, high = 0.0;
    for (int i = 0; i < 9; ++i) {
        vec2 open = ssao_now(texel + vec2(float(i % 3), float(i / 3)) - 1.0);
        low = open.y > 0.0 ? min(low, open.x) : low;
        high = open.y > 0.0 ? max(high, open.x) : high;
    }
    return clamp(v, low, high);
}
#endif

void main() {
    vec2 texel = floor(gl_FragCoord.xy);
    SsaoPixel pixel = ssao_pixel();
    vec2 before = ssao_before(pixel);
#ifdef MOVED
    before.x = ssao_within(before.x, texel);
#endif
    float frames = clamp(before.y, 0.0, u_most - 1.0) + 1.0;
    float open = pixel.z > 0.0 ? mix(before.x, ssao_now(texel).x, 1.0 / frames) : 1.0;
#ifndef SMALL
    out_open = vec4(open);
#endif
    out_history = pixel.z > 0.0 ? vec4(open, frames, pixel.z, 0.0) : vec4(0.0);
}
