// What a sphere hides of a hemisphere, of rays of a length at most. Lengths in any one unit.

// Square of the sine of the cone of rays from a point, d from the middle of a sphere of radius r, that meet it within the length t.
// From inside of it no length makes a difference.
float ssao_cone(float d, float r, float t) {
    float tangent = d * d - r * r;
    if (tangent > 0.0 && t <= d - r) return 0.0;
    if (t * t >= tangent) return min(r * r / max(d * d, 1e-30), 1.0);
    float cosine = (t * t + tangent) / max(2.0 * t * d, 1e-30);
    return clamp(1.0 - cosine * cosine, 0.0, 1.0);
}

// The cosine-weighted share of the hemisphere that such a cone hides, q the square of its sine, u the cosine of its axis: q u, or
// less of it where it dips below the horizon (Nusselt's analog: an ellipse, cut by the circle of the horizon).
float ssao_cone_factor(float q, float u) {
    float dip = q - u * u;
    if (dip <= 0.0 || q <= 0.0) return q * max(u, 0.0);
    float c = max(1.0 - q, 1e-7);
    float turn = acos(clamp(-u * sqrt(c / max(q * (1.0 - u * u), 1e-30)), -1.0, 1.0));
    return clamp((q * u * turn - sqrt(dip * c) + atan(sqrt(dip / c))) * 0.31830989, 0.0, 1.0);
}
