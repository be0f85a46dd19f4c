// Slices of the hemisphere: planes through the direction to the viewer, in which occluders are intervals of angle.
//
// Within a slice an angle is replaced by u in 0..1, the share of the slice's cosine-weighted visibility below it
// (between the two edges of the hemisphere), so that occlusion is plain length in u: sums are exact, and bits that
// are equally spaced in u are of equal measure. With gamma the angle of the projected normal from the viewer,
//   T = cos g + g sin g,   m(t, s) = (cos g sin^2 t + s sin g (t - sin t cos t)) / 2,   u = u0 + s m(t, s) / T
// for an angle t from the viewer on side s, from the slice measure |N_s| cos(t - g) |sin t| of Jimenez et al.,
// "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016.

#include "lib/precision.glsl"

const float SSAO_PI = 3.14159265358979;

// |error| < 7e-5 (Abramowitz & Stegun 4.4.45); exact at 0, where it matters, and at pi.
float ssao_acos(float x) {
    float a = abs(x);
    float r = sqrt(max(0.0, 1.0 - a)) * (1.5707963 + a * (-0.2121144 + a * (0.0742610 - a * 0.0187293)));
    return x < 0.0 ? SSAO_PI - r : r;
}

// The direction at right angles to v (the unit direction to the viewer) that turn, a unit vector, picks around it.
// Frame: Duff et al., "Building an Orthonormal Basis, Revisited", 2017; v.z > 0 wherever there is a surface.
vec3 ssao_along(vec3 v, vec2 turn) {
    float a = -dot(v.xy, turn) / (1.0 + max(v.z, 0.0));
    return vec3(turn + a * v.xy, -dot(v.xy, turn));
}

// How far the image of p moves, in pixels per scene unit and times clip w, as p moves along a direction.
vec2 ssao_texels(vec3 p, vec3 along) {
    vec2 slope = along.xy + (u_w.x > 0.0 ? -p.xy / p.z : -u_ray0) * along.z;
    return u_uv_per_unit * slope * u_size;
}

struct SsaoSlice {
    vec3 along;     // unit, away from the pixel, at right angles to the viewer
    vec3 axis;      // unit, out of the slice
    vec2 normal;    // of the surface: its parts along and to the viewer, as unit vector
    LOW float weight;  // |N_s| T, what the slice contributes
    float share;    // of the normal out of the slice, over |N_s|
    float u0;       // u of the viewer's direction
    vec2 curve;     // (cos g, sin g) / 2 T
};

// The slice in direction along (unit, at right angles to v) for the normal n and the unit direction v to the viewer.
SsaoSlice ssao_slice(vec3 along, vec3 v, vec3 n) {
    SsaoSlice s;
    s.along = along;
    s.axis = cross(v, along);
    vec2 projected = vec2(dot(n, along), dot(n, v));
    float length_ns = max(length(projected), 1e-4);
    s.normal = projected / length_ns;
    s.share = dot(n, s.axis) / length_ns;
    float gamma = ssao_acos(clamp(s.normal.y, -1.0, 1.0)) * (s.normal.x < 0.0 ? -1.0 : 1.0);
    // A surface that faces away, as smooth normals may near silhouettes, is taken edge on.
    gamma = clamp(gamma, -0.5 * SSAO_PI, 0.5 * SSAO_PI);
    float sin_g = s.normal.x, cos_g = max(s.normal.y, 0.0);
    float t = cos_g + gamma * sin_g;
    s.curve = 0.5 / t * vec2(cos_g, sin_g);
    s.weight = length_ns * t;
    s.u0 = 0.5 / t * (cos_g * cos_g * cos_g - sin_g * (0.5 * SSAO_PI - gamma - sin_g * cos_g));
    return s;
}

// The offset d from the pixel in the slice, as (along, to the viewer). Taps lie on texel centres and so a little off the
// slice: they slide into it along the surface, which leaves a plane a plane.
vec2 ssao_into_slice(SsaoSlice s, vec3 d, vec3 v) {
    return vec2(dot(d, s.along), dot(d, v)) + s.normal * (dot(d, s.axis) * s.share);
}

// u of a direction q in the slice on side +1 or -1 (q.x side >= 0), clamped to the hemisphere. t - sin t cos t is
// pi/2 - cos t (P(sin t) + sin t) with P(x) = acos(x) / sqrt(1 - x^2), a polynomial of degree 4 within 1e-4.
float ssao_u(SsaoSlice s, vec2 q, float side) {
    vec2 cs = q.yx * (inversesqrt(max(dot(q, q), 1e-30)) * vec2(1.0, side));
    float x = cs.y;
    float p = 1.5707042 + x * (0.0059233 + x * (0.7234546 + x * (-0.4245332 + x * 0.1251507)));
    float u = s.u0 + side * s.curve.x * (x * x) + s.curve.y * (0.5 * SSAO_PI - cs.x * p);
    return cs.x < -side * s.normal.x ? 0.5 + 0.5 * side : clamp(u, 0.0, 1.0);
}
