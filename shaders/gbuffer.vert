// Instances are placed relative to the middle of the scene, and the view matrix starts there too (both computed in
// 64-bit), so a scene far from the origin loses nothing to 32-bit floats.
#needs es300
uniform mat4 u_view;
uniform mat4 u_projection;

ATTRIBUTE vec3 a_position;
ATTRIBUTE mat4 a_model;
VARYING vec3 v_position;
#ifdef SMOOTH
ATTRIBUTE ivec4 a_normal;  // 16-bit integers, of any length
VARYING vec3 v_normal;
#endif
#ifdef VERTEX_COLOR
ATTRIBUTE vec4 a_color;
VARYING vec4 v_color;
#endif
#ifdef TEXTURED
ATTRIBUTE vec2 a_uv;
VARYING vec2 v_uv;
#endif
#ifdef LABELS_TARGET
flat VARYING int v_copy;
#endif
#ifdef BAKED_VERTEX
ATTRIBUTE float a_baked;
VARYING float v_baked;
#endif
#ifdef BAKED_TEXTURE
ATTRIBUTE vec2 a_baked;
VARYING vec2 v_baked;
#endif

void main() {
    mat4 model_view = u_view * a_model;
    vec4 p = model_view * vec4(a_position, 1.0);
    v_position = p.xyz;
#ifdef LABELS_TARGET
    v_copy = gl_InstanceID;
#endif
    gl_Position = u_projection * p;
#ifdef SMOOTH
    // The cofactor matrix turns normals right under non-uniform scales, and mirrored ones up to a sign.
    vec3 x = model_view[0].xyz, y = model_view[1].xyz, z = model_view[2].xyz;
    v_normal = mat3(cross(y, z), cross(z, x), cross(x, y)) * vec3(a_normal.xyz);
#endif
#ifdef VERTEX_COLOR
    v_color = a_color;
#endif
#ifdef TEXTURED
    v_uv = a_uv;
#endif
#if defined(BAKED_VERTEX) || defined(BAKED_TEXTURE)
    v_baked = a_baked;
#endif
}
