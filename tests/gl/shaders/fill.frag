// One value everywhere.
uniform float u_value;

void main() {
    frag_color = vec4(u_value);
}
