// A volume's surface, by rays: an iso-surface, or with TRANSFER the place where half of the light is lost.
#needs es300
precision highp sampler3D;
#include "lib/surface.glsl"
#include "lib/trilinear.glsl"

uniform vec2 u_texel;
uniform mat4 u_projection;
uniform mat3 u_ray_start;  // (u, v, 1) -> where the ray of a pixel meets the plane of depth u_ray_depth.x, in voxels
uniform mat3 u_ray_step;   // (u, v, 1) -> how far it goes, in voxels, as its depth grows by u_ray_depth.y
uniform vec2 u_ray_depth;
uniform vec2 u_ray_range;  // of the camera's near and far planes, in steps from u_ray_depth.x
uniform mat3 u_gradient;   // a gradient over voxels -> one in view space, of another length
uniform int u_most;        // steps that a ray may take
uniform vec3 u_color;      // sRGB

// The unit normal of a gradient over voxels, on the side that a ray comes from. Gradients and rays are in dual spaces, so their
// product says which way the ray goes through the surface, whatever the affine; there is no gradient where a field is flat.
vec3 ssao_facing(vec3 slope, vec3 along) {
    vec3 n = u_gradient * slope * (dot(slope, along) > 0.0 ? -1.0 : 1.0);
    float length2 = dot(n, n);
    return length2 > 0.0 ? n * inversesqrt(length2) : vec3(0.0, 0.0, 1.0);
}

#ifdef TRANSFER
#include "lib/opacity_ray.glsl"

// The unit normal to the side of less opacity. At the rim of a translucent thing, where half of the light is lost beyond its
// middle, that is its far side: there the normal is at right angles to the ray, and not turned into the material.
vec3 ssao_rim_normal(vec3 slope, float value, vec3 along) {
    float reach = 0.5 * max(length(slope), 1.0 / 255.0);
    float rise = ssao_transfer(value + reach).a - ssao_transfer(value - reach).a;
    if (rise > 0.0 || (rise == 0.0 && dot(slope, along) > 0.0)) slope = -slope;  // where opacity is level, to the viewer
    vec3 n = u_gradient * slope, ray = normalize(inverse(transpose(u_gradient)) * along);
    n -= ray * max(dot(n, ray) + 1e-3 * length(n), 0.0);  // a little towards the viewer, so that rounding turns none around
    float length2 = dot(n, n);
    return length2 > 0.0 ? n * inversesqrt(length2) : -ray;
}
#else
#include "lib/surface_ray.glsl"
#endif

void main() {
    vec3 at = vec3(ssao_place(u_texel), 1.0);
    vec3 start = u_ray_start * at, along = u_ray_step * at;
    along = mix(along, vec3(1e-9), lessThan(abs(along), vec3(1e-9)));  // so that no plane is 0 / 0 away
    vec3 enters = (u_first - start) / along, ends = (u_end - start) / along;
    vec3 nearer = min(enters, ends), farther = max(enters, ends);
    float from = u_ray_range.x;
#ifdef BEHIND
    float front = ssao_front();
    if (front <= 0.0) discard;
    from = max(from, (front * (1.0 + 1e-5) + u_gap - u_ray_depth.x) / u_ray_depth.y + 1e-3);
#endif
    float first = max(max(nearer.x, nearer.y), max(nearer.z, from));
    float last = min(min(farther.x, farther.y), min(farther.z, u_ray_range.y));
    if (!(last > first)) discard;
    Seen seen = ssao_trace(start, along, first, last);
    if (!seen.found) discard;

    float z = u_ray_depth.x + seen.s * u_ray_depth.y;
    ssao_write_met_depth(z, u_projection);
#ifdef NORMAL
    vec3 p = start + seen.s * along;
#ifdef TRANSFER
    vec3 geometric = ssao_rim_normal(ssao_smooth_gradient(p), ssao_field(p), along);
    vec3 n = geometric;
#else
    vec3 geometric = ssao_facing(ssao_cell_gradient(ssao_cell(seen.cell), clamp(p - seen.cell, 0.0, 1.0)), along);
    vec3 n = geometric;
#ifdef SMOOTH
    n = ssao_facing(ssao_smooth_gradient(p), along);
    if (dot(n, geometric) < 0.0) n = -n;
#endif
#endif
    ssao_write_normals(geometric, n);
#ifdef COLOR
#ifdef TRANSFER
    ssao_write_color(seen.color, n);
#else
    ssao_write_color(u_color, n);
#endif
#endif
#endif
}
