// One for each fragment, of spheres.
#needs es300
flat VARYING vec3 v_facing;

void main() {
    frag_color = vec4(v_facing.x < 9.0 ? 1.0 : 0.0);
}
