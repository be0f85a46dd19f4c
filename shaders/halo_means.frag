// Means over a box of the image around every SCALE-th pixel, from a summed-area table: nearness (0 where there is background) and what
// is covered. The box is as wide for all, and shrinks on both sides where it meets the border, so that planes have their own nearness.
#needs es300
#include "lib/view.glsl"
#include "lib/inverse_depth.glsl"
#include "lib/depth_table.glsl"

uniform sampler2D u_range;
uniform highp usampler2D u_sums;
uniform vec2 u_share;    // the whole image's size over that of this part
uniform float u_width;   // of the box to each side, texels for each pixel of this part's height

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(u_sums, 0) - 1;
    ivec2 room = min(here, last - here), h = min(ivec2(clamp(u_width * u_share.y * u_size.y, 1.0, 127.0)), room);
    ivec2 low = here - h - 1, high = here + h;
    uvec4 sums = ssao_sums(u_sums, high, last) - ssao_sums(u_sums, ivec2(low.x, high.y), last)
        - ssao_sums(u_sums, ivec2(high.x, low.y), last) + ssao_sums(u_sums, low, last);
    vec2 range = ssao_table_range(texelFetch(u_range, ivec2(0), 0).rg);
    float count = float((2 * h.x + 1) * (2 * h.y + 1)), covered = float(sums.z) / count;
    float share = (float(sums.x) + float(sums.y) * (1.0 / 65536.0)) / (65535.0 * count);
    frag_color = vec4(share * range.y + covered * range.x, covered, 0.0, 1.0);
}
