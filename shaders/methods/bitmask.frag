// Visibility bitmask over slices of the hemisphere: each tap sets the bits that a slab behind its texel hides. The bits are
// of equal cosine-weighted measure (lib/slice.glsl), so counting them is the slice integral.
//
// VEIL: what lies behind a texel and behind its slab no depth buffer knows. All sectors from its front to the edge of the
// hemisphere are its veil, and are hidden in part. Sectors are counted by the shares in u_shares.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/output.glsl"
#include "lib/accumulate.glsl"
#include "lib/slice.glsl"
#include "lib/bitmask.glsl"
#ifdef FALLOFF
#include "lib/falloff.glsl"
#endif

// Few taps are written out one by one, which software renderers run a third faster; many would take them minutes to compile.
#if SLICES * STEPS > 32
#define LOOPS
#endif

uniform sampler2D u_z;
#ifdef SECOND_LAYER
uniform sampler2D u_z2;
uniform vec2 u_behind_texel;  // one pixel, as uv of u_z2
uniform float u_behind_scale;  // pixels along each side of a texel of it
#endif
#ifdef BOUNCE
uniform sampler2D u_bounce;   // linear light that each pixel reflects, and which share of it is dimmed as the environment is here
uniform sampler2D u_normals;
uniform vec2 u_bounce_texel;  // one pixel, as uv of both
#endif
uniform sampler2D u_noise;    // (cos, sin) of the first slice's direction, place of the taps between their steps
uniform float u_noise_width;  // pixels
uniform float u_per_radius;   // 1 / scene units
uniform vec2 u_thickness;     // of slabs, in radii: constant part, and share of the way to the next tap
uniform float u_max_radius;   // pixels
uniform vec2 u_next_slice;    // (cos, sin) of the angle between slices
#ifdef VEIL
uniform vec3 u_shares;        // by which a sector is hidden: of slabs, of the near veil and of the far veil; a hidden one is in all three
#endif

// What all taps of a slice have in common. Lengths are in radii, offsets on the image in pixels.
struct SsaoSweep {
    SsaoSlice slice;
    vec2 at;      // the pixel
#ifdef BOUNCE
    vec3 viewer;  // unit, to it
#endif
    vec2 way;     // direction on the image
    vec2 room;    // to the border of the image, to the + and the - side
    vec2 reach;   // to go at most
    float offset;
    float z;
    vec2 to_z;    // what a unit of depth adds along the slice and to the viewer
    mat2 to_xy;   // what a pixel aside adds to these for each unit of depth
#ifndef PINHOLE
    mat2 to_xy0;  // and whatever the depth
#endif
};

// What the taps of a slice have hidden so far.
struct SsaoHidden {
    uint bits;
#ifdef VEIL
    uint near, far;  // the veils
#endif
#ifdef FALLOFF
    float sum;  // of them, by how much they count
#endif
#ifdef BOUNCE
    vec4 gained;  // what those reflect whose surface is seen from here, and how many they are
    vec3 dimmed;
    uint fresh;   // sectors that the last tap was the first to hide
    vec2 front;   // where it lies
#endif
};

#ifdef VEIL
// How far away a texel may be whose veil counts, in radii, and squared.
const float SSAO_NEAR_VEIL2 = 2.25, SSAO_FAR_VEIL2 = 9.0;
#endif

// What rises more steeply from tap to tap (to the viewer, over aside) is taken for the edge of something, not for a slope.
const float SSAO_STEEP = 3.0;

// Add what a surface hides, offset pixels aside at depth z: within the radius, and behind it as far as the slab is thick.
// A slope goes on beyond its last tap, on average half way to the next one: ahead times what it rose from the tap before.
void ssao_hide(SsaoSweep w, vec2 offset, float z, float side, float thickness, float ahead, inout vec2 last, inout SsaoHidden hidden) {
    vec2 front = w.to_xy * offset * z + w.to_z * (z - w.z);
#ifndef PINHOLE
    front += w.to_xy0 * offset;
#endif
    vec2 rise = front - last;
    last = front;
    float distance2 = dot(front, front), height = dot(front, w.slice.normal);
    // What hides nothing itself (below the middle of the outermost bit, see lib/slice.glsl) does not begin to by going on.
    bool slope = height * abs(height) > distance2 / 32.0 && abs(rise.y) < SSAO_STEEP * side * rise.x;
    bool rises = side * (front.x * rise.y - front.y * rise.x) > 0.0;
    // Over one radius all rays of sight are as good as parallel: the slab reaches straight away from the viewer.
    vec2 edge = slope && rises ? front + ahead * rise : front;
#ifdef VEIL
    // Where a ray as long as the radius stays in front of what is seen, it is known to be free: the veil is beside it.
    edge.y = distance2 < 1.0 ? edge.y : min(edge.y, sqrt(max(1.0 - front.x * front.x, 0.0)));
#endif
    float near = ssao_u(w.slice, edge, side);
    float far = ssao_u(w.slice, front - vec2(0.0, thickness), side);
    uint bits = side > 0.0 ? ssao_bits(near, far) : ssao_bits(far, near);
    // At the border a tap may be the pixel itself, whose depth in a smaller target is not the same to the last bits.
    bool aside = z > 0.0 && front.x * side > 0.0 && offset != vec2(0.0);
#ifdef VEIL
    uint veil = side > 0.0 ? ssao_bits(near, 1.0) : ssao_bits(0.0, near);
    hidden.near |= aside && distance2 < SSAO_NEAR_VEIL2 ? veil : 0u;
    hidden.far |= aside && distance2 < SSAO_FAR_VEIL2 ? veil : 0u;
#endif
    bits = aside && distance2 < 1.0 ? bits : 0u;
#ifdef FALLOFF
    // Outwards, the first tap to hide a sector is what a ray there meets first.
    hidden.sum += ssao_count(bits & ~hidden.bits) * ssao_rho(sqrt(min(distance2, 1.0)));
#endif
#ifdef BOUNCE
    hidden.fresh = bits & ~hidden.bits;
    hidden.front = front;
#endif
    hidden.bits |= bits;
}

#ifdef BOUNCE
// Add what the tap reflects into the sectors that it is the first to hide, where its surface faces this one (after Therrien et al.).
void ssao_gain(SsaoSweep w, vec2 uv, inout SsaoHidden hidden) {
    if (hidden.fresh == 0u) return;
    vec3 n = ssao_decode_normal(SAMPLE(u_normals, uv).xy);
    bool faces = dot(n, w.slice.along) * hidden.front.x + dot(n, w.viewer) * hidden.front.y < 0.0;
    if (!faces) return;
    vec4 light = SAMPLE(u_bounce, uv);
    float sectors = ssao_count(hidden.fresh);
    hidden.gained += vec4(light.rgb, 1.0) * sectors;
    hidden.dimmed += light.rgb * (light.a * sectors);
}
#endif

void ssao_texel(
    SsaoSweep w, vec2 way, float side, float thickness, float ahead, inout vec4 last, inout SsaoHidden hidden
) {
    vec2 offset = floor(way + 0.5);  // free of where the pixel lies, so a picture in tiles has the taps of a whole one
    vec2 tap = w.at + offset;
    ssao_hide(w, offset, SAMPLE(u_z, tap * u_texel).r * u_per_radius, side, thickness, ahead, last.xy, hidden);
#ifdef BOUNCE
    ssao_gain(w, tap * u_bounce_texel, hidden);
#endif
#ifdef SECOND_LAYER
    // A texel that stands for several pixels shows what lies behind the one in its middle.
    vec2 middle = floor(tap / u_behind_scale) * u_behind_scale + (floor(0.5 * u_behind_scale) + 0.5);
    float z = SAMPLE(u_z2, middle * u_behind_texel).r * u_per_radius;
    ssao_hide(w, middle - w.at, z, side, thickness, ahead, last.zw, hidden);
#endif
}

// Step k to both sides. Taps crowd near the pixel (power 3/2); a slab is thicker where the next tap is farther away.
void ssao_step(SsaoSweep w, float k, inout vec4 plus, inout vec4 minus, inout SsaoHidden hidden) {
    vec3 q = max(vec3(k - 1.0, k, k + 1.0) + w.offset, 0.0) / float(STEPS);
    vec3 t = q * sqrt(q);
    float thickness = u_thickness.x + u_thickness.y * (t.z - t.y);
    vec2 r = min(w.reach * t.y + 1.0, w.room);
    float ahead = 0.5 * (t.z - t.y) / (t.y - t.x);
    ssao_texel(w, w.way * r.x, 1.0, thickness, ahead, plus, hidden);
    ssao_texel(w, -w.way * r.y, -1.0, thickness, ahead, minus, hidden);
}

// Pixels from at along way to the border of the image, from the centre of the last texel.
float ssao_room(vec2 at, vec2 way) {
    vec2 border = mix(at - 0.5, u_size - 0.5 - at, vec2(greaterThan(way, vec2(0.0))));
    vec2 room = border / max(abs(way), 1e-6);
    return min(room.x, room.y);
}

#ifdef BENT
uniform sampler2D u_directions;  // of the eighths of a slice, (along, to the viewer), two in a texel; by the sine of gamma

vec2 ssao_two(uint fours, vec4 directions) {
    return float(fours & 15u) * directions.xy + float((fours >> 4u) & 15u) * directions.zw;
}

// The sum of the directions of the bits that are set.
vec2 ssao_directions(uint bits, float sin_gamma) {
    uint fours = ssao_fours(bits);
    vec2 sum = vec2(0.0);
#repeat 4 sum += ssao_two(fours >> uint(8 * @), SAMPLE(u_directions, vec2(0.5 + 0.498 * sin_gamma, (float(@) + 0.5) / 4.0)));
    return sum;
}
#endif

// How many sectors are hidden. Within a slab a hit is known, and with a falloff how near it is; a veil knows no distance, and
// its hits count as much as those at all distances within the radius do on average.
float ssao_hidden(SsaoHidden hidden) {
#ifdef FALLOFF
    float known = hidden.sum;
#else
    float known = ssao_count(hidden.bits);
#endif
#if defined(VEIL) && defined(FALLOFF)
    vec2 veils = vec2(ssao_count(hidden.near & ~hidden.bits), ssao_count(hidden.far & ~hidden.bits));
    return (u_shares.x + u_shares.y + u_shares.z) * known + SSAO_MEAN_RHO * dot(u_shares.yz, veils);
#elif defined(VEIL)
    return u_shares.x * known + dot(u_shares.yz, vec2(ssao_count(hidden.near), ssao_count(hidden.far)));
#else
    return known;
#endif
}

// Add the slice in direction turn.
void ssao_sweep(SsaoPixel pixel, vec3 p, vec3 v, vec2 turn, float offset, inout SsaoSum sum) {
    vec3 along = ssao_along(v, turn);
    vec2 texels = ssao_texels(p, along) * (1.0 / (u_per_radius * ssao_w(-p.z)));
    float pixels = max(length(texels), 1e-6);
    SsaoSweep w;
    w.slice = ssao_slice(along, v, pixel.n);
    w.at = pixel.at;
#ifdef BOUNCE
    w.viewer = v;
#endif
    w.way = texels / pixels;
    float reach = min(pixels, u_max_radius);
    w.room = vec2(ssao_room(w.at, w.way), ssao_room(w.at, -w.way));
    w.reach = min(vec2(reach), max(w.room - 1.0, 0.0));
    w.offset = offset;
    w.z = pixel.z * u_per_radius;
    vec2 uv = pixel.at * u_texel;
    vec2 right = u_ray[0] * u_texel.x, up = u_ray[1] * u_texel.y;
    w.to_z = ssao_into_slice(w.slice, vec3(u_ray * uv + u_ray0, -1.0), v);
    w.to_xy = mat2(ssao_into_slice(w.slice, vec3(right, 0.0), v), ssao_into_slice(w.slice, vec3(up, 0.0), v));
#ifndef PINHOLE
    right = u_org[0] * u_texel.x * u_per_radius, up = u_org[1] * u_texel.y * u_per_radius;
    w.to_xy0 = mat2(ssao_into_slice(w.slice, vec3(right, 0.0), v), ssao_into_slice(w.slice, vec3(up, 0.0), v));
#endif
    vec4 plus = vec4(0.0), minus = vec4(0.0);
    SsaoHidden hidden;
    hidden.bits = 0u;
#ifdef VEIL
    hidden.near = hidden.far = 0u;
#endif
#ifdef FALLOFF
    hidden.sum = 0.0;
#endif
#ifdef BOUNCE
    hidden.gained = vec4(0.0);
    hidden.dimmed = vec3(0.0);
    hidden.fresh = 0u;
    hidden.front = vec2(0.0);
#endif
#ifdef LOOPS
    for (int k = 0; k < STEPS; k++) ssao_step(w, float(k), plus, minus, hidden);
#else
#repeat STEPS ssao_step(w, float(@), plus, minus, hidden);
#endif
    float count = ssao_hidden(hidden);
    sum.open += vec2(1.0 - count / 32.0, 1.0) * w.slice.weight;
#ifdef BOUNCE
    sum.gained += vec4(hidden.gained.rgb - count / 32.0 * hidden.dimmed, hidden.gained.a) * (w.slice.weight / float(32 * SLICES));
#endif
#ifdef BENT
    vec2 lost = ssao_directions(hidden.bits, w.slice.normal.x);
    float bits = ssao_count(hidden.bits);
#ifdef VEIL
    lost = u_shares.x * lost + u_shares.y * ssao_directions(hidden.near, w.slice.normal.x)
        + u_shares.z * ssao_directions(hidden.far, w.slice.normal.x);
    bits = dot(u_shares, vec3(bits, ssao_count(hidden.near), ssao_count(hidden.far)));
#endif
#ifdef FALLOFF
    lost *= count / max(bits, 1e-3);
#endif
    sum.lost += (lost.x * along + lost.y * v) * (w.slice.weight / float(32 * SLICES));
#endif
}

// One slice more, and on to the direction of the next.
void ssao_turn(SsaoPixel pixel, vec3 p, vec3 v, float offset, inout vec2 turn, inout SsaoSum sum) {
    ssao_sweep(pixel, p, v, turn, offset, sum);
    turn = mat2(u_next_slice, -u_next_slice.y, u_next_slice.x) * turn;
}

void main() {
    SsaoPixel pixel = ssao_pixel();
    vec3 p = ssao_position(pixel.at * u_texel, max(pixel.z, 1e-30));
    vec3 v = ssao_to_viewer(p);
    vec4 noise = SAMPLE(u_noise, gl_FragCoord.xy / u_noise_width);
    vec2 turn = noise.xy;
    SsaoSum sum = ssao_nothing();
#ifdef LOOPS
    for (int i = 0; i < SLICES; i++) ssao_turn(pixel, p, v, noise.z, turn, sum);
#else
#repeat SLICES ssao_turn(pixel, p, v, noise.z, turn, sum);
#endif
    // The weights of all directions are 1 on average, and the filter averages those of the tile: it finds the hidden share of the
    // whole hemisphere when each pixel's is taken times its weight. Near 1 that would be clipped, and it is left as it is.
    float hidden = min(1.0 - sum.open.x / max(sum.open.y, 1e-6), 1.0), weight = sum.open.y / float(SLICES);
    float deep = hidden * hidden * hidden * hidden;
    ssao_write(1.0 - hidden * mix(weight, 1.0, deep), pixel.z);
#ifdef BENT
    ssao_write_bent(sum.lost, pixel.n);
#endif
#ifdef BOUNCE
    ssao_write_gained(sum.gained);
#endif
}
