// View-space normals from linear depth alone. Along each axis the neighbour is taken that lies on the same surface:
// the one whose own continuation meets this pixel best. Both sides of an edge get the normal of their own surface.
#include "lib/view.glsl"
#include "lib/normal.glsl"
uniform sampler2D u_z;

// Outside the image there is nothing.
float ssao_z(vec2 uv) { return uv == clamp(uv, vec2(0.0), vec2(1.0)) ? SAMPLE(u_z, uv).r : 0.0; }

// Window depth is affine over the image on a plane: 1/z for a pinhole, z itself for a parallel projection.
float ssao_affine(float z) { return u_w.x > 0.0 ? 1.0 / z : z; }

// How badly the surface through the neighbours at one and two steps misses this pixel; large when they are missing.
float ssao_miss(float here, float z1, float z2) {
    if (!(z1 > 0.0)) return 3e38;
    float a = ssao_affine(z1);
    return z2 > 0.0 ? abs(2.0 * a - ssao_affine(z2) - here) : abs(a - here);
}

// Derivative of position along one axis, from the better side.
vec3 ssao_tangent(vec2 uv, vec2 texel, vec3 p, float here) {
    float l1 = ssao_z(uv - texel), l2 = ssao_z(uv - 2.0 * texel);
    float r1 = ssao_z(uv + texel), r2 = ssao_z(uv + 2.0 * texel);
    float l = ssao_miss(here, l1, l2), r = ssao_miss(here, r1, r2);
    if (min(l, r) > 2e38) return ssao_position(uv + texel, -p.z) - p;
    return l < r ? p - ssao_position(uv - texel, l1) : ssao_position(uv + texel, r1) - p;
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = ssao_z(uv);
    vec3 n = vec3(0.0, 0.0, 1.0);
    if (z > 0.0) {
        vec3 p = ssao_position(uv, z);
        float here = ssao_affine(z);
        // In units of depth, so that squares neither overflow nor vanish in scenes of tiny or huge units.
        vec3 dx = ssao_tangent(uv, vec2(u_texel.x, 0.0), p, here) / z;
        vec3 dy = ssao_tangent(uv, vec2(0.0, u_texel.y), p, here) / z;
        n = cross(dx, dy) * (u_size.x * u_size.y);
        float length2 = dot(n, n);
        n = length2 > 1e-30 && length2 < 1e30 ? n * inversesqrt(length2) : ssao_to_viewer(p);
        n = dot(n, p) > 0.0 ? -n : n;
    }
    frag_color = vec4(ssao_encode_normal(n), 0.0, 0.0);
}
