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
    // Tested on the bits: compilers may assume that floats are never NaN. Exponent 255 is infinity or NaN; the upper
    // bound keeps squares of distances finite.
    uint bits = floatBitsToUint(z);
    bool usable = (bits >> 23u) < 190u && z > 0.0;
    frag_color = vec4(usable ? z : 0.0);
}
