// Which corner of a box a vertex is, each component 0 or 1: 14 vertices, in the order of one strip of triangles.
vec3 ssao_box_corner() {
    int bit = 1 << gl_VertexID;
    return vec3((0x287A & bit) != 0, (0x02AF & bit) != 0, (0x31E3 & bit) != 0);
}
