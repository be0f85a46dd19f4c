// An sRGB colour times a factor that is meant in linear light, without decoding the colour.
// The power segments of the curve combine: encode(f decode(c)) = f^(1/2.4) (c + 0.055) - 0.055. Its linear toe, where
// the product is simply f c, takes over below; the result is within 0.5/255 of the exact curve for all c and f in 0..1.
vec3 ssao_times_linear(vec3 srgb, float factor) {
    float f = clamp(factor, 0.0, 1.0);
    float g = f > 0.0 ? exp2(log2(f) * (1.0 / 2.4)) : 0.0;
    return max(g * (srgb + 0.055) - 0.055, f * srgb);
}
