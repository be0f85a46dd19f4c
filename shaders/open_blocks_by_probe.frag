// Which blocks are taken for open: those whose own probe and all around it see nothing.
uniform vec2 u_target_texel;  // 1 / size of the image of blocks
uniform sampler2D u_probe;

float ssao_probe(vec2 offset) { return SAMPLE(u_probe, (gl_FragCoord.xy + offset) * u_target_texel).r; }

void main() {
    float least = 1.0;
#repeat 9 least = min(least, ssao_probe(vec2(mod(float(@), 3.0) - 1.0, floor(float(@) / 3.0) - 1.0)));
    frag_color = vec4(least >= 0.999 ? 1.0 : 0.0);
}
