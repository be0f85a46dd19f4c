// Whether a ball lies behind all that is drawn already where it may be seen: its bounds in the image against four cells of that
// level of a pyramid of farthest depths that suits them (Greene, Kass & Miller, "Hierarchical Z-Buffer Visibility", 1993).
uniform highp sampler2D u_drawn;  // the pixels at column 0, right of them the other levels, one above the other
uniform ivec2 u_drawn_size;       // pixels
uniform int u_levels;

float ssao_farthest_drawn(ivec2 cell, int level) {
    ivec2 all = textureSize(u_drawn, 0);
    ivec2 corner = level == 0 ? ivec2(0) : ivec2(all.x / 3 * 2, all.y - (all.y >> (level - 1)));
    return texelFetch(u_drawn, corner + cell, 0).r;
}

bool ssao_lies_behind(vec3 center, float radius, mat4 projection) {
    vec4 clip = projection * vec4(center, 1.0);
    float x_reach = radius * length(vec3(projection[0].x, projection[1].x, projection[2].x));
    float y_reach = radius * length(vec3(projection[0].y, projection[1].y, projection[2].y));
    float w_reach = radius * length(vec3(projection[0].w, projection[1].w, projection[2].w));
    if (!(clip.w > 1.01 * w_reach)) return false;  // it reaches around the eye
    vec2 least = clip.xy - vec2(x_reach, y_reach), most = clip.xy + vec2(x_reach, y_reach);
    float nearest = 1.0 / (clip.w - w_reach), farthest = 1.0 / (clip.w + w_reach);
    vec2 size = vec2(u_drawn_size);
    // A pixel more on each side, for what rounding does to edges.
    vec2 low = (0.5 + 0.5 * min(least * nearest, least * farthest)) * size - 1.0;
    vec2 high = (0.5 + 0.5 * max(most * nearest, most * farthest)) * size + 1.0;
    ivec2 first = ivec2(clamp(low, vec2(0.0), size - 1.0)), last = ivec2(clamp(high, vec2(0.0), size - 1.0));
    ivec2 across = last - first;
    int level = 0;
    for (int i = 0; i < 6 && (max(across.x, across.y) >> level) > 1; ++i) ++level;
    ivec2 a = first >> level, b = last >> level;
    if (b.x - a.x > 1 || b.y - a.y > 1) {
        if (level == u_levels) return false;
        ++level;
        a = first >> level;
        b = last >> level;
    }
    float behind = max(
        max(ssao_farthest_drawn(a, level), ssao_farthest_drawn(ivec2(b.x, a.y), level)),
        max(ssao_farthest_drawn(ivec2(a.x, b.y), level), ssao_farthest_drawn(b, level)));
    return -center.z - radius > behind * (1.0 + 1e-5);
}
