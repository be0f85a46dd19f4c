// Depth of any kind to linear depth in scene units, with background and everything unusable (NaN, infinity, zero,
// negative) as 0.
#include "lib/view.glsl"
uniform sampler2D u_depth;
#ifdef WINDOW_DEPTH
uniform float u_depth_far;  // window depth of the far plane: 1, or 0 when depth is reversed
uniform vec4 u_depth_num;
uniform vec4 u_depth_den;
#endif

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float d = SAMPLE(u_depth, uv).r;
#ifdef WINDOW_DEPTH
    vec4 p = vec4(uv, d - u_depth_far, 1.0);
    float den = dot(u_depth_den, p);
    float z = d == u_depth_far || !(abs(den) > 0.0) ? 0.0 : dot(u_depth_num, p) / den;
#else
    float z = d;
#endif
    // Infinity and NaN have no place in what follows; the bounds keep squares of distances finite and above zero.
#ifdef ES100
    bool usable = z > 1.1e-19 && z < 9e18;
#else
    // Tested on the bits: compilers may assume that floats are never NaN. Sign 0, exponent from -63 to 62.
    uint exponent = floatBitsToUint(z) >> 23u;
    bool usable = exponent >= 64u && exponent < 190u;
#endif
    frag_color = vec4(usable ? z : 0.0);
#ifdef COVER
    gl_FragDepth = usable ? 0.0 : 1.0;
#endif
}
