// A visibility from elsewhere (rays, say) and linear depth, in the form that filters read.
#include "lib/output.glsl"
uniform vec2 u_texel;
uniform sampler2D u_given;
uniform sampler2D u_z;

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    ssao_write(SAMPLE(u_given, uv).r, SAMPLE(u_z, uv).r);
}
