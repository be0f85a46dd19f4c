// Depth as the lecture wants it: distance over the far distance, 1 on background.
uniform vec2 u_texel;
uniform sampler2D u_z;
uniform float u_far;

void main() {
    float z = SAMPLE(u_z, gl_FragCoord.xy * u_texel).r;
    frag_color = vec4(z > 0.0 ? min(z / u_far, 1.0) : 1.0);
}
