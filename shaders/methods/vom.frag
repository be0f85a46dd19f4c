// Vicinity occlusion maps, after Diaz, Yela, Vazquez, "Vicinity Occlusion Maps: Enhanced Depth Perception of Volumetric Models",
// CGI 2008: what hides a pixel is read off the mean depth of boxes around it. Each box has 3 x 3 blocks; the eight around the middle
// lie in four slices through the pixel, to one side or to the other. Smaller boxes lie in the middle block.
// Over an even grid a plane's nearness is affine, and so are its means: its blocks lie in the tangent plane to the last digits.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/inverse_depth.glsl"
#include "lib/depth_table.glsl"
#include "lib/output.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_range;
uniform highp usampler2D u_sums;
uniform float u_scale;     // pixels of the image to a texel, along each side
uniform float u_strength;
uniform float u_per_fade;  // 1 / the radii over which what lies beyond the radius stops to count

const float LARGEST = 127.0;  // half width of a block, texels: 255^2 are below 2^16

// Sums over three columns of blocks, of all rows up to one.
struct SsaoRow {
    uvec4 left;
    uvec4 middle;
    uvec4 right;
};

SsaoRow ssao_row(ivec2 here, int y, int b, ivec2 last) {
    uvec4 s0 = ssao_sums(u_sums, ivec2(here.x - 3 * b - 2, here.y + y), last), s1 = ssao_sums(u_sums, ivec2(here.x - b - 1, here.y + y), last);
    uvec4 s2 = ssao_sums(u_sums, ivec2(here.x + b, here.y + y), last), s3 = ssao_sums(u_sums, ivec2(here.x + 3 * b + 1, here.y + y), last);
    return SsaoRow(s1 - s0, s2 - s1, s3 - s2);
}

// Sines of the angles at which blocks rise above the tangent plane, one a slice. gain: how much nearer they are than the pixel, away:
// how far in the plane of the image, slope: what gain the tangent plane has there; all in units of the reach. Cut off far beyond it.
vec4 ssao_rise(vec4 gain, vec4 away, vec4 slope, vec4 covered) {
    gain = clamp(gain, -1e3, 1e3);
    vec4 way2 = away * away + gain * gain;
    vec4 within = 1.0 - clamp((sqrt(way2) - 1.0) * u_per_fade, 0.0, 1.0);
    return max(away * (gain - slope) * inversesqrt(max(way2 * (away * away + slope * slope), 1e-37)), 0.0) * within * covered;
}

// What all boxes of a pixel have in common. step: from a texel to the one on its right, above, above on the right, and below on the
// right; slope: what the tangent plane gains by it. In units of the reach.
struct SsaoCenter {
    ivec2 here;
    uvec4 own;
    vec4 step;
    vec4 slope;
    float depth;  // for each share of the range of nearness
};

// Raise front and back, the highest rise in each slice to either side, by a box of a half width in texels.
void ssao_box(inout vec4 front, inout vec4 back, SsaoCenter c, float texels) {
    int b = int(clamp((texels - 1.0) / 3.0 + 0.5, 0.0, LARGEST));
    uint count = uint((2 * b + 1) * (2 * b + 1));
    float far = float(2 * b + 1);
    ivec2 last = textureSize(u_sums, 0) - 1;
    SsaoRow r0 = ssao_row(c.here, -3 * b - 2, b, last), r1 = ssao_row(c.here, -b - 1, b, last);
    SsaoRow r2 = ssao_row(c.here, b, b, last), r3 = ssao_row(c.here, 3 * b + 1, b, last);
    vec4 covered, gain;
    gain = ssao_gains(r2.right - r1.right, r3.middle - r2.middle, r3.right - r2.right, r1.right - r0.right, c.own, count, covered);
    front = max(front, ssao_rise(gain * c.depth, c.step * far, c.slope * far, covered));
    gain = ssao_gains(r2.left - r1.left, r1.middle - r0.middle, r1.left - r0.left, r3.left - r2.left, c.own, count, covered);
    back = max(back, ssao_rise(gain * c.depth, c.step * far, -c.slope * far, covered));
}

void main() {
    SsaoCenter c;
    c.here = ivec2(gl_FragCoord.xy);
    ivec2 pixel = c.here * int(u_scale);
    float z = texelFetch(u_z, pixel, 0).r;
    vec3 n = ssao_decode_normal(texelFetch(u_normal, pixel, 0).xy);
    vec2 range = ssao_table_range(texelFetch(u_range, ivec2(0), 0).rg), texel = u_scale * u_texel;
    c.own = ssao_table_entry(z, range);
    vec2 right = (u_ray[0] * z + u_org[0]) * texel.x, up = (u_ray[1] * z + u_org[1]) * texel.y;
    c.step = vec4(length(right), length(up), length(right + up), length(right - up));
    float widest = max(max(c.step.x, c.step.y), 1e-30), reach = max(ssao_reach(z), 1e-6 * widest);
    c.step /= reach;
    // From nearness to depth, of a pinhole z^2: in an order that stays within the floats.
    float far = u_w.x > 0.0 ? z : 1.0, fars = min(far / reach, 1e10);
    vec2 along = clamp(ssao_slope((vec2(pixel) + 0.5) * u_texel, 1.0, n), -1e10, 1e10) * (u_scale * fars);
    c.slope = clamp(vec4(along, along.x + along.y, along.x - along.y), -1e4, 1e4);
    c.depth = fars * min(far * range.y, 1e20);
    float texels = reach / widest;
    vec4 front = vec4(0.0), back = vec4(0.0);
#repeat SIZES ssao_box(front, back, c, texels * pow(RATIO, float(@)));
    // A side of a slice hides half of the squared sine, where the normal lies in it. Within a texel there is nothing to see.
    float occlusion = u_strength * 0.125 * (dot(front, front) + dot(back, back));
    ssao_write(texels > 0.5 ? 1.0 - occlusion : 1.0, z);
}
