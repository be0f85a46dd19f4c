// The cosine-weighted share of the hemisphere about n that a polygon hides (Lambert 1760; Baum, Rushmeier & Winget, "Improving
// Radiosity Solutions through the Use of Analytically Determined Form-Factors", 1989): a sum over edges of the angle that each
// spans, times the cosine of its plane's normal. What lies below the horizon is cut off. Corners are relative to the receiver.

// The share of one edge, times 2 pi; 0 where the receiver lies on its line.
float ssao_edge(vec3 a, vec3 b, vec3 n) {
    a *= inversesqrt(max(dot(a, a), 1e-37));
    b *= inversesqrt(max(dot(b, b), 1e-37));
    vec3 turn = cross(a, b);
    float sine = length(turn);
    return sine > 1e-12 ? atan(sine, dot(a, b)) * dot(n, turn) / sine : 0.0;
}

// A triangle by the heights of its corners above the horizon. Where an edge leaves it and where one comes back are the ends of
// the edge that closes the part above.
float ssao_triangle_form_factor(vec3 a, vec3 b, vec3 c, vec3 n) {
    vec3 corners[3] = vec3[3](a, b, c);
    vec3 leaves = vec3(0.0), returns = vec3(0.0);
    float sum = 0.0;
    for (int i = 0; i < 3; i++) {
        vec3 from = corners[i], to = corners[i == 2 ? 0 : i + 1];
        float start = dot(from, n), end = dot(to, n);
        if (start <= 0.0 && end <= 0.0) continue;
        if (start > 0.0 && end <= 0.0) leaves = to = mix(from, to, start / (start - end));
        if (start <= 0.0 && end > 0.0) returns = from = mix(to, from, end / (end - start));
        sum += ssao_edge(from, to, n);
    }
    return abs(sum + ssao_edge(leaves, returns, n)) * 0.15915494;
}
