#include "lib/precision.glsl"

// An sRGB colour times a factor that is meant in linear light, without decoding and encoding the colour.
// The power segments of the curve combine: encode(f decode(c)) = g (c + 0.055) - 0.055 with g = f^(1/2.4). Two cases
// remain: a colour on the linear toe stays there (f c), and one that is dimmed down to the toe gets
// 12.92 (u / 1.055)^2.4 with u = g (c + 0.055), a function of u alone. Polynomials stand for the two powers (software
// renderers pay most for powers); the result is within 0.4/255 of the exact curve for all c and f in 0..1.
LOW vec3 ssao_times_linear(LOW vec3 srgb, LOW float factor) {
    LOW float f = clamp(factor, 0.0, 1.0);
    LOW float q = sqrt(sqrt(f));
    LOW float g = q * (0.0846306 + q * (1.4096958 + q * (-0.7709888 + q * 0.2766624)));
    LOW vec3 u = g * (srgb + 0.055);
    LOW vec3 toe = mix(u * u * (2.3126459 + 22.6079677 * u), f * srgb, vec3(lessThan(srgb, vec3(0.04045))));
    return mix(toe, u - 0.055, vec3(greaterThan(u, vec3(0.09545))));
}
