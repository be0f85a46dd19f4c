// A summed-area table of nearness (lib/inverse_depth.glsl) and of what is covered (Crow, "Summed-Area Tables for Texture Mapping",
// 1984). A texel of it stands for the first of the pixels below it, which keeps the grid even.
// Nearness is a share of the range that the image shows, in 32 bits: two halves of 16, so that sums over fewer than 2^16
// texels fit into 32 bits. Larger sums wrap, and their differences are exact all the same.
// Needs lib/view.glsl and lib/inverse_depth.glsl.

// (high and low half of the nearness, 1, 0) of a texel that shows something at linear depth z; zeros of background.
uvec4 ssao_table_entry(float z, vec2 range) {
    float share = 65535.0 * clamp((ssao_nearness(z) - range.x) / range.y, 0.0, 1.0);
    float high = floor(share);
    return z > 0.0 ? uvec4(uint(high), uint((share - high) * 65536.0), 1u, 0u) : uvec4(0u);
}

// (lowest nearness, how far the highest is from it), from what the image's range was reduced to.
vec2 ssao_table_range(vec2 most) { return vec2(-most.y, max(most.x + most.y, 1e-28)); }

// a - b, exact before it is rounded to a float.
float ssao_minus(uint a, uint b) { return a >= b ? float(a - b) : -float(b - a); }

// Sums over all texels up to this one; last is that of the table.
uvec4 ssao_sums(highp usampler2D table, ivec2 texel, ivec2 last) {
    ivec2 inside = texel + (last - texel) * ivec2(greaterThan(texel, last));
    return texel.x >= 0 && texel.y >= 0 ? texelFetch(table, inside, 0) : uvec4(0u);
}

// By how much the mean over a box is nearer than own, as a share of the range. sums: over its count texels, fewer than 2^16.
float ssao_gain(uvec4 sums, uvec4 own, uint count) {
    float gain = ssao_minus(sums.x, count * own.x) + ssao_minus(sums.y, count * own.y) * (1.0 / 65536.0);
    return gain / (65535.0 * float(count));
}

// The same of four boxes, and 1 for those that are covered all over.
vec4 ssao_gains(uvec4 a, uvec4 b, uvec4 c, uvec4 d, uvec4 own, uint count, out vec4 covered) {
    covered = vec4(equal(uvec4(a.z, b.z, c.z, d.z), uvec4(count)));
    return vec4(ssao_gain(a, own, count), ssao_gain(b, own, count), ssao_gain(c, own, count), ssao_gain(d, own, count));
}
