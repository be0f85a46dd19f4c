// A triangle around the outline of each sphere, an instance a block of them, without vertex data: sphere and corner go by the
// number of the vertex. Seen from the eye, the outline is a circle in a plane of its own (Tarini, Cignoni &
// Montani, "Ambient Occlusion and Edge Cueing", 2006, place theirs likewise), so the cover is exact under every lens.
#needs es300
uniform mat4 u_projection;
uniform vec4 u_eye;    // view space: the point where all rays meet and 1; of a parallel projection its direction and 0
uniform float u_pixel; // side of a pixel, scene units per unit of clip w
uniform vec2 u_w;      // w of the camera's own projection = u_w.x z + u_w.y
uniform int u_columns; // of the textures
uniform highp sampler2D u_spheres;  // centre and radius
#ifdef COLOR
uniform vec4 u_color;  // sRGB
#ifdef VERTEX_COLOR
uniform sampler2D u_colors;
#endif
flat VARYING vec4 v_color;
#endif

ATTRIBUTE mat4 a_model_view;
ATTRIBUTE int a_first;  // sphere of the block; behind the last one the texture has spheres of radius 0
#ifdef LABELS_TARGET
ATTRIBUTE int a_copy;
flat VARYING int v_copy;
#endif
flat VARYING vec4 v_sphere;  // centre in view space, radius
flat VARYING vec3 v_origin;  // where in the image the centre is seen, 0..1, and its depth; depth 0: it need not be seen at all

#ifdef DRAWN
#include "lib/drawn_depth.glsl"
#endif

const float MARGIN = 0.125;  // pixels around the outline: rasterisers round corners to a fraction of one

void main() {
    int of_block = gl_VertexID / 3, corner = gl_VertexID - 3 * of_block, sphere = a_first + of_block;
    ivec2 texel = ivec2(sphere % u_columns, sphere / u_columns);
    vec4 data = texelFetch(u_spheres, texel, 0);
    vec3 center = (a_model_view * vec4(data.xyz, 1.0)).xyz;
    float radius = data.w * length(a_model_view[0].xyz);
    v_sphere = vec4(center, radius);
#ifdef LABELS_TARGET
    v_copy = a_copy;
#endif
#ifdef COLOR
    v_color = u_color;
#ifdef VERTEX_COLOR
    v_color = texelFetch(u_colors, texel, 0);
#endif
#endif
    vec4 middle = u_projection * vec4(center, 1.0);
    vec3 away = u_eye.w > 0.0 ? center - u_eye.xyz : u_eye.xyz;
    bool close = u_eye.w > 0.0 && -away.z < 2.0 * radius;
    v_origin = close ? vec3(0.0) : vec3(0.5 + 0.5 * middle.xy / middle.w, -center.z);

    // The outline: a circle about `nearer` in the plane through it that the eye looks at. Scaled first: squares of huge and of
    // tiny distances leave the floats.
    float scale = max(max(abs(away.x), abs(away.y)), max(abs(away.z), radius));
    away /= max(scale, 1e-37);
    float share = u_eye.w > 0.0 ? (radius / scale) * (radius / scale) / dot(away, away) : 0.0;
    vec2 at = vec2(float(corner == 1) * 2.0, float(corner == 2) * 2.0) * 2.0 - 1.0;  // (-1, -1), (3, -1), (-1, 3)
#ifdef DRAWN
    if (ssao_lies_behind(center, radius, u_projection)) radius = 0.0;
#endif
    if (radius <= 0.0) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    } else if (!(share < 0.999)) {  // the eye is inside, or almost: the whole image
        gl_Position = vec4(at, 0.0, 1.0);
    } else {
        vec3 view = normalize(away);
        vec3 x = normalize(abs(view.y) < 0.9 ? vec3(-view.z, 0.0, view.x) : vec3(0.0, view.z, -view.y));
        vec3 y = cross(view, x);
        float reach = radius * sqrt(1.0 - share) + MARGIN * u_pixel * abs(u_w.y - u_w.x * center.z);
        vec3 nearer = center - share * (scale * away) * u_eye.w;
        vec2 of_circle = corner == 0 ? vec2(-1.7320508, -1.0) : corner == 1 ? vec2(1.7320508, -1.0) : vec2(0.0, 2.0);
        gl_Position = u_projection * vec4(nearer + reach * (of_circle.x * x + of_circle.y * y), 1.0);
        gl_Position.z = 0.0;  // fragments have their own depth; what reaches before the near plane is not cut off
    }
}
