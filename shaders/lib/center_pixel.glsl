// The pixel that a fragment stands for, and what it shows. In a target smaller than the image (SMALL) it is one of the pixels
// below the fragment, which downsample.frag chose; which one is in the lowest bits of its depth. A probe (PROBE) stands for the
// pixel in the middle.
uniform vec2 u_target_texel;  // 1 / size of the target
uniform float u_scale;        // pixels of the image along each side of a fragment
uniform sampler2D u_pixel_z;
uniform sampler2D u_pixel_normal;

struct SsaoPixel {
    vec2 at;  // its centre, pixels of the image
    float z;
    vec3 n;
};

SsaoPixel ssao_pixel() {
#ifdef PROBE
    vec2 middle = min(floor(gl_FragCoord.xy) * u_scale + floor(0.5 * u_scale) + 0.5, u_size - 0.5);
    return SsaoPixel(middle, SAMPLE(u_pixel_z, middle * u_texel).r, ssao_decode_normal(SAMPLE(u_pixel_normal, middle * u_texel).xy));
#endif
    vec2 here = gl_FragCoord.xy * u_target_texel;
    SsaoPixel pixel = SsaoPixel(gl_FragCoord.xy, SAMPLE(u_pixel_z, here).r, ssao_decode_normal(SAMPLE(u_pixel_normal, here).xy));
#ifdef SMALL
    uint which = floatBitsToUint(pixel.z);
    pixel.at = floor(gl_FragCoord.xy) * u_scale + vec2(float(which & 3u), float((which >> 2u) & 3u)) + 0.5;
#endif
    return pixel;
}
