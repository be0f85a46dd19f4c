// Visibility as 32 bits, after Therrien, Levesque, Gilet, "Screen Space Indirect Lighting with Visibility Bitmask", 2023.

// The bits whose middles lie between a and b, both in 0..1, a <= b. No shift reaches 32, which GLSL leaves undefined.
uint ssao_bits(float a, float b) {
    uint first = uint(clamp(a * 32.0 + 0.5, 0.0, 32.0));
    uint last = uint(clamp(b * 32.0 + 0.5, 0.0, 32.0));
    uint below_last = last >= 32u ? 0xFFFFFFFFu : (1u << last) - 1u;
    uint below_first = first >= 32u ? 0xFFFFFFFFu : (1u << first) - 1u;
    return below_last & ~below_first;
}

// How many bits are set; GLSL ES 3.00 has no bitCount.
float ssao_count(uint b) {
    b -= (b >> 1u) & 0x55555555u;
    b = (b & 0x33333333u) + ((b >> 2u) & 0x33333333u);
    b = (b + (b >> 4u)) & 0x0F0F0F0Fu;
    return float((b * 0x01010101u) >> 24u);
}
