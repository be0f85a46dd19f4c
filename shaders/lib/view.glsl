// Points from pixels and linear depth, for any projection (see scene.projection.ViewConstants). uv (0,0) is the lower left.
uniform vec2 u_size;         // pixels
uniform vec2 u_texel;        // 1 / u_size
uniform mat2 u_ray;          // view xy = (u_ray uv + u_ray0) z + (u_org uv + u_org0)
uniform vec2 u_ray0;
uniform mat2 u_org;
uniform vec2 u_org0;
uniform vec2 u_w;            // clip w = u_w.x z + u_w.y
uniform mat2 u_uv_per_unit;  // uv moved by an offset parallel to the image = u_uv_per_unit offset / w

// View-space point at uv with linear depth z (scene units).
vec3 ssao_position(vec2 uv, float z) {
    vec2 xy = (u_ray * uv + u_ray0) * z;
#ifndef PINHOLE  // all rays of a pinhole pass through the eye
    xy += u_org * uv + u_org0;
#endif
    return vec3(xy, -z);
}

float ssao_w(float z) { return u_w.x * z + u_w.y; }

// Direction from the point p to the viewer. Divided by depth first: squares of tiny or huge distances leave the floats.
vec3 ssao_to_viewer(vec3 p) {
#ifdef PINHOLE
    return normalize(vec3(p.xy / p.z, 1.0));
#else
    // u_w.x is 0 for a parallel projection: its rays run along (u_ray0, -1).
    return normalize(vec3(u_w.x > 0.0 ? p.xy / p.z : -u_ray0, 1.0));
#endif
}
