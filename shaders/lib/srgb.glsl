// The sRGB curve (IEC 61966-2-1), in full precision.
vec3 ssao_srgb_to_linear(vec3 c) {
    return mix(pow(max(c + 0.055, 0.0) / 1.055, vec3(2.4)), c / 12.92, vec3(lessThanEqual(c, vec3(0.04045))));
}

vec3 ssao_linear_to_srgb(vec3 c) {
    return mix(1.055 * pow(max(c, 0.0), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}
