// The number of each texel, beyond what floats can tell apart.
#needs es300
uniform vec2 u_size;
layout(location = 0) out uvec4 number;

void main() {
    number = uvec4(uint(gl_FragCoord.y) * uint(u_size.x) + uint(gl_FragCoord.x) + 0xFFFF0000u);
}
