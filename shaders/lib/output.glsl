// What an occlusion pass writes. With PACKED one 32-bit float carries linear depth and, in the low 8 bits of its
// mantissa, visibility: a blur then needs one fetch a tap. Depth keeps a relative precision of 2^-16.
#ifdef PACKED
float ssao_pack(float visibility, float z) {
    uint bits = (floatBitsToUint(z) + 0x80u) & 0xFFFFFF00u;
    return z > 0.0 ? uintBitsToFloat(bits | uint(visibility * 255.0 + 0.5)) : 0.0;
}

// (visibility, linear depth); linear depth 0 is background.
vec2 ssao_unpack(float packed_texel) {
    uint bits = floatBitsToUint(packed_texel);
    return vec2(float(bits & 0xFFu) * (1.0 / 255.0), uintBitsToFloat(bits & 0xFFFFFF00u));
}
#endif

#ifndef TARGETS
// Visibility in 0..1 of a pixel with linear depth z; background is open.
void ssao_write(float visibility, float z) {
    // min and max in this order turn a NaN into 1: open, never a black pixel.
    float open = z > 0.0 ? max(0.0, min(1.0, visibility)) : 1.0;
#ifdef FINITE
    // For ssao-gl stress: 0 where the line above has to save the pixel. On the bits, as floats may be taken to be finite.
    open = z > 0.0 && ((floatBitsToUint(visibility) >> 23u) & 0xFFu) == 0xFFu ? 0.0 : 1.0;
#endif
#ifdef PACKED
    frag_color = vec4(ssao_pack(open, z));
#else
    frag_color = vec4(open);
#endif
}
#endif
