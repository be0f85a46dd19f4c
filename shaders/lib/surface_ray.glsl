// The first point of a ray at which the field changes sides of 0, exact to rounding.
Seen ssao_trace(vec3 start, vec3 along, float s, float last) {
    vec3 inverse = 1.0 / along, forward = step(0.0, along);
    vec3 cell = clamp(floor(start + s * along), u_first, u_end - 1.0);
    bool inside = ssao_value(ssao_cell(cell), clamp(start + s * along - cell, 0.0, 1.0)) >= 0.0;
    bool found = false;
    vec4 cubic = vec4(0.0);
    vec2 bracket = vec2(1.0, 0.0);
    float next = s;
    for (int i = 0; i < u_most; i++) {
        Leap leap = ssao_leap(cell);
        vec3 beyond = ssao_beyond(start, along, inverse, forward, leap, s, last, next);
        if (leap.one_sided) {
            found = leap.inside != inside;
        } else {
            cubic = ssao_cubic(ssao_cell(cell), clamp(start + s * along - cell, 0.0, 1.0), (next - s) * along);
            found = (cubic.w >= 0.0) != inside;  // lost to rounding between two cells
            if (!found) {
                bracket = ssao_bracket(cubic);
                found = bracket.x <= bracket.y;
            }
        }
        if (found || next >= last || ssao_left(beyond)) break;
        cell = beyond;
        s = next;
    }
    if (bracket.x <= bracket.y) s += ssao_root(cubic, bracket) * (next - s);
    return Seen(found, s, cell, vec3(0.0));
}
