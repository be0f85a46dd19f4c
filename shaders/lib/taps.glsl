// Where a method looks: how far, and on which texels. Needs lib/view.glsl.
uniform float u_radius;       // scene units
uniform float u_max_radius;   // pixels
uniform float u_noise_width;  // pixels

// The radius at linear depth z; less where its image is larger than taps can cover.
float ssao_reach(float z) {
    mat2 disk = u_uv_per_unit * (u_radius / max(ssao_w(z), 1e-30));
    vec2 extent = (abs(disk[0]) + abs(disk[1])) * u_size;
    return u_radius * min(1.0, u_max_radius / max(max(extent.x, extent.y), 1e-6));
}

// The middle of the texel at uv: depth is that of the middle, and a point off it would leave the surface.
vec2 ssao_middle(vec2 uv) { return (floor(uv * u_size) + 0.5) * u_texel; }

bool ssao_inside(vec2 uv) { return uv == clamp(uv, vec2(0.0), vec2(1.0)); }

// From p to what is seen at uv with linear depth z, in units of the reach; cut off beyond it, where squares could overflow.
vec3 ssao_offset(vec2 uv, float z, vec3 p, float reach) { return clamp((ssao_position(uv, z) - p) / reach, -2.0, 2.0); }

// Where the point p is seen, near uv; outside the image when it lies behind the viewer.
vec2 ssao_project(vec3 p, vec2 uv) {
    float w = ssao_w(-p.z);
    vec2 way = u_uv_per_unit * (p.xy - ssao_position(uv, -p.z).xy);
    return w > 0.0 ? clamp(uv + way / max(w, 1e-30), -1.0, 2.0) : vec2(-1.0);
}
