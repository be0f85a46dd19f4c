// Visibility as 32 bits, after Therrien, Levesque, Gilet, "Screen Space Indirect Lighting with Visibility Bitmask", 2023.

// 2^i for i in 0..32, without the shift by 32 that GLSL leaves undefined: what overflows is 0.
uint ssao_bit(int i) { return i > 31 ? 0u : 1u << i; }

// The bits whose middles lie between a and b, both in 0..1, a <= b.
uint ssao_bits(float a, float b) { return ssao_bit(int(b * 32.0 + 0.5)) - ssao_bit(int(a * 32.0 + 0.5)); }

// How many bits are set; GLSL ES 3.00 has no bitCount.
float ssao_count(uint b) {
    b -= (b >> 1u) & 0x55555555u;
    b = (b & 0x33333333u) + ((b >> 2u) & 0x33333333u);
    b = (b + (b >> 4u)) & 0x0F0F0F0Fu;
    return float((b * 0x01010101u) >> 24u);
}

// A share of the 32 bits, spread evenly: bit i is set when its mirrored number is below 32 share. Smaller sets lie in larger
// ones. (Comparison of two numbers of five digits, all 32 bits at once, from the lowest digit up.)
uint ssao_spread(float share) {
    uint k = uint(clamp(share, 0.0, 1.0) * 32.0 + 0.5), below = 0u;
    below = (k & 1u) != 0u ? below | 0x0000FFFFu : below & 0x0000FFFFu;
    below = (k & 2u) != 0u ? below | 0x00FF00FFu : below & 0x00FF00FFu;
    below = (k & 4u) != 0u ? below | 0x0F0F0F0Fu : below & 0x0F0F0F0Fu;
    below = (k & 8u) != 0u ? below | 0x33333333u : below & 0x33333333u;
    below = (k & 16u) != 0u ? below | 0x55555555u : below & 0x55555555u;
    return k > 31u ? 0xFFFFFFFFu : below;
}
