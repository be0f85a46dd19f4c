// Where the ray through a pixel meets a sphere. The ray is taken about the sphere's centre, so that nothing cancels out
// however far away it is.
#needs es300
#define COPIES
#include "lib/surface.glsl"
#include "lib/view.glsl"

uniform vec2 u_near_far;  // linear depth of the clip planes
uniform mat4 u_projection;

flat VARYING vec4 v_sphere;
flat VARYING vec3 v_origin;
#ifdef COLOR
flat VARYING vec4 v_color;
#endif

bool ssao_seen(float z) {
#ifdef BEHIND
    if (ssao_hidden(z)) return false;
#endif
    return z >= u_near_far.x && z <= u_near_far.y;
}

void main() {
    vec2 uv = ssao_place(u_texel);
    float radius = v_sphere.w;
    vec3 ray = vec3(u_ray * uv + u_ray0, -1.0);
    // A point of the ray, from the centre, in radii: that at the centre's depth, or where the ray begins.
    vec3 from = v_origin.z != 0.0
        ? vec3((u_ray * v_origin.z + u_org) * (uv - v_origin.xy), 0.0)
        : vec3(u_org * uv + u_org0, 0.0) - v_sphere.xyz;
    from /= radius;
    float ray2 = dot(ray, ray);
    vec3 moment = cross(from, ray);
    float inside = ray2 - dot(moment, moment);
    if (!(inside >= 0.0)) discard;
    float middle = -dot(from, ray), half_chord = sqrt(inside);
    float near = (middle - half_chord) / ray2, far = (middle + half_chord) / ray2;
    // The outside, or what is seen of the inside where the outside is cut off.
    bool outside = ssao_seen(v_origin.z + radius * near);
    float along = outside ? near : far;
    float z = v_origin.z + radius * along;
    if (!outside && !ssao_seen(z)) discard;
    ssao_write_met_depth(z, u_projection);
#ifdef NORMAL
    vec3 n = normalize(from + along * ray);
    n = outside ? n : -n;
    ssao_write_normals(n, n);
#ifdef COLOR
    ssao_write_color(v_color.rgb, n);
#endif
#endif
}
