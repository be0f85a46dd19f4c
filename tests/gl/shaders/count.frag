// One more than in the last frame.
uniform vec2 u_texel;
uniform sampler2D u_before;

void main() {
    frag_color = vec4(SAMPLE(u_before, gl_FragCoord.xy * u_texel).r + 1.0);
}
