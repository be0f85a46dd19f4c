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
    // Infinity and NaN have no place in what follows; the upper bound keeps squares of distances finite.
#ifdef ES100
    bool usable = z > 0.0 && z < 9e18;
#else
    // Tested on the bits: compilers may assume that floats are never NaN. Sign 0, exponent below 2^63.
    bool usable = (floatBitsToUint(z) >> 23u) < 190u && z > 0.0;
#endif
    frag_color = vec4(usable ? z : 0.0);
}
