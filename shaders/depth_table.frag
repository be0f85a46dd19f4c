// A step of a summed-area table by recursive doubling, here of four: each texel gains what lies 1, 2 and 3 strides before it
// (Hensley et al., "Fast Summed-Area Table Generation and its Applications", 2005). The first step makes the entries, too.
#needs es300
#include "lib/view.glsl"
#include "lib/inverse_depth.glsl"
#include "lib/depth_table.glsl"

#ifdef FIRST
uniform sampler2D u_z;
uniform sampler2D u_range;
#else
uniform highp usampler2D u_sums;
#endif
layout(location = 0) out highp uvec4 out_sums;  // see ssao_table_entry

uvec4 ssao_at(ivec2 texel) {
#ifdef FIRST
    float z = texelFetch(u_z, texel * SCALE, 0).r;
    return ssao_table_entry(z, ssao_table_range(texelFetch(u_range, ivec2(0), 0).rg));
#else
    return texelFetch(u_sums, texel, 0);
#endif
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    uvec4 sums = ssao_at(here);
    for (int i = 1; i < 4; i++) {
        ivec2 there = here - i * ivec2(STRIDE_X, STRIDE_Y);
        if (there.x >= 0 && there.y >= 0) sums += ssao_at(there);
    }
    out_sums = sums;
}
