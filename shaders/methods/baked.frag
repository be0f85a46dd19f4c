// Visibility that the scene keeps, as the G-buffer has it.
#include "lib/view.glsl"
#include "lib/output.glsl"

uniform sampler2D u_z;
uniform sampler2D u_baked;
uniform float u_strength;

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    ssao_write(mix(1.0, SAMPLE(u_baked, uv).r, u_strength), SAMPLE(u_z, uv).r);
}
