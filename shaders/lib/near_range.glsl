// Where one level ends and the other begins. Needs lib/view.glsl and lib/taps.glsl.

// The near range at linear depth z, scene units: less where its image is larger than taps can cover, or so small that taps would
// show the pixel itself, from 8 pixels down to none at 2.
float ssao_near_range(float z) {
    float reach = ssao_reach(z);
    mat2 disk = u_uv_per_unit * (reach / max(ssao_w(z), 1e-30));
    vec2 extent = (abs(disk[0]) + abs(disk[1])) * u_size;
    return reach * clamp((max(extent.x, extent.y) - 2.0) / 6.0, 0.0, 1.0);
}
