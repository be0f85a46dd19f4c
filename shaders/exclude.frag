// Open where what is seen receives no occlusion: where the depth of all lies before that of what does.
uniform vec2 u_texel;
uniform sampler2D u_z;
uniform sampler2D u_receiver_z;

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r, receiver = SAMPLE(u_receiver_z, uv).r;
    // Two draws of one surface may differ in their last digits.
    if (receiver > 0.0 && receiver <= z * (1.0 + 1e-5)) discard;
    frag_color = vec4(1.0);
}
