// One for each fragment of each prism, of solid triangles.
#needs es300
flat VARYING float v_solid;

void main() {
    frag_color = vec4(v_solid);
}
