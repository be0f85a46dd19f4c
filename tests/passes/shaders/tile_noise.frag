// A visibility that repeats over tiles of 4x4 and takes 16 values.
#needs es300
#include "lib/output.glsl"
uniform vec2 u_target_texel;
uniform sampler2D u_z;

void main() {
    vec2 i = mod(floor(gl_FragCoord.xy), 4.0);
    float order = mod(i.x * 7.0 + i.y * 4.0, 16.0);
    ssao_write((order + 0.5) / 16.0, SAMPLE(u_z, gl_FragCoord.xy * u_target_texel).r);
}
