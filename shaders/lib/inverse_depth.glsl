// Depth in a form that is affine over the image on every plane, and grows towards the viewer: 1/z for a pinhole, -z for a
// parallel projection. Needs lib/view.glsl; other projections have none.
float ssao_nearness(float z) { return u_w.x > 0.0 ? 1.0 / max(z, 1e-30) : -z; }

// What the nearness of the tangent plane at uv, z with normal n gains from pixel to pixel, to the right and up.
vec2 ssao_slope(vec2 uv, float z, vec3 n) {
    vec3 ray = vec3(u_ray * uv + u_ray0, -1.0);
    vec2 gain = u_w.x > 0.0 ? n.xy * u_ray : n.xy * u_org;
    float toward = dot(n, ray);  // below 0 where the surface faces the viewer
    return gain * u_texel / min(toward * (u_w.x > 0.0 ? z : 1.0), -1e-30);
}
