// Visibility as 32 bits, after Therrien, Levesque, Gilet, "Screen Space Indirect Lighting with Visibility Bitmask", 2023.

// 2^i for i in 0..32, without the shift by 32 that GLSL leaves undefined: what overflows is 0.
uint ssao_bit(int i) { return i > 31 ? 0u : 1u << i; }

// The bits whose middles lie between a and b, both in 0..1, a <= b.
uint ssao_bits(float a, float b) { return ssao_bit(int(b * 32.0 + 0.5)) - ssao_bit(int(a * 32.0 + 0.5)); }

// How many bits of each four are set, in these four.
uint ssao_fours(uint b) {
    b -= (b >> 1u) & 0x55555555u;
    return (b & 0x33333333u) + ((b >> 2u) & 0x33333333u);
}

// How many bits are set; GLSL ES 3.00 has no bitCount.
float ssao_count(uint b) {
    b = ssao_fours(b);
    b = (b + (b >> 4u)) & 0x0F0F0F0Fu;
    return float((b * 0x01010101u) >> 24u);
}
