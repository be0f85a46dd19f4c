// What half floats can hold is declared LOW: weights, colours, light. MOBILE makes it mediump. Positions, depths, offsets,
// distances and sums never are; nor directions that they follow from: those of the taps, and normals whose tangent plane is
// measured in pixels, as at grazing angles the 11 bits of a half float tilt it out of its own pixels; nor visibilities to be
// averaged, which lie on ties of the 8 bits that are kept of them.
#ifdef MOBILE
#define LOW mediump
#else
#define LOW
#endif

#ifdef HALF  // for tests: LOW variables are rounded like half floats, on drivers too that take mediump for highp
float ssao_half(float x) {
    uint bits = floatBitsToUint(x), sign = bits & 0x80000000u, size = bits & 0x7FFFFFFFu;
    if (size > 0x7F800000u) return x;                                                   // NaN
    if (size >= 0x477FF000u) return uintBitsToFloat(sign | 0x7F800000u);                // 65520 and more are infinite
    if (size < 0x38800000u) return floor(x * 16777216.0 + 0.5) * (1.0 / 16777216.0);    // below 2^-14: steps of 2^-24
    return uintBitsToFloat(sign | ((size + 0xFFFu + ((size >> 13u) & 1u)) & 0xFFFFE000u));
}
vec2 ssao_half(vec2 v) { return vec2(ssao_half(v.x), ssao_half(v.y)); }
vec3 ssao_half(vec3 v) { return vec3(ssao_half(v.xy), ssao_half(v.z)); }
vec4 ssao_half(vec4 v) { return vec4(ssao_half(v.xy), ssao_half(v.zw)); }
#endif
