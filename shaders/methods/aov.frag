// What triangles hide of a pixel's hemisphere, added up, as visibility. Where they overlap the sum counts twice.
#include "lib/view.glsl"
#include "lib/output.glsl"

uniform vec2 u_target_texel;
uniform sampler2D u_pixel_z;
uniform sampler2D u_hidden;
uniform float u_strength;

void main() {
    vec2 here = gl_FragCoord.xy * u_target_texel;
    float hidden = u_strength * SAMPLE(u_hidden, here).r;
#if COMPENSATION == 1
    float open = exp(-hidden);
#else
    float open = 1.0 - hidden;
#endif
    ssao_write(open, SAMPLE(u_pixel_z, here).r);
}
