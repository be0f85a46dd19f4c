// What there is to shade at full size: a depth buffer of 0 there, 1 on background and half way where blocks are open; and what
// is left where nothing is drawn.
#needs es300
#include "lib/output.glsl"
uniform vec2 u_texel;
uniform vec2 u_per_block;  // blocks for each pixel, as uv of their image
uniform sampler2D u_z;
uniform sampler2D u_open;

void main() {
    float z = SAMPLE(u_z, gl_FragCoord.xy * u_texel).r;
    ssao_write(1.0, z);
    gl_FragDepth = !(z > 0.0) ? 1.0 : SAMPLE(u_open, floor(gl_FragCoord.xy) * u_per_block).r > 0.5 ? gl_FragCoord.z : 0.0;
}
