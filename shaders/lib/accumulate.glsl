// What a pixel gathers, of its slices or of the texels around it, by their weights; and with BENT the bent normal: the mean of
// the open directions by their cosines, which is 2/3 n over a free hemisphere. Drawn and filtered (BENT 1) is what occluders
// take away from that mean, 0 where all is open; at last (BENT 2) comes the unit vector. With BOUNCE also what the hidden sectors
// that are seen reflect, and how many these are; at last (BOUNCE 2) their mean, in alpha whether there are any.
struct SsaoSum {
    vec2 open;  // (visibility, 1)
#ifdef BENT
    vec3 lost;
#endif
#ifdef BOUNCE
    vec4 gained;
#endif
};

SsaoSum ssao_nothing() {
    SsaoSum sum;
    sum.open = vec2(0.0);
#ifdef BENT
    sum.lost = vec3(0.0);
#endif
#ifdef BOUNCE
    sum.gained = vec4(0.0);
#endif
    return sum;
}

#ifdef BENT
layout(location = 1) out vec4 frag_bent;

void ssao_write_bent(vec3 lost, vec3 n) {
#if BENT == 1
    frag_bent = vec4(lost, 0.0);
#else
    vec3 open = n * (2.0 / 3.0) - lost;
    // A little of what lies straight ahead is open always, so that no noise turns the vector behind the surface.
    open += n * max(0.05 - dot(open, n), 0.0);
    frag_bent = vec4(ssao_encode_normal(normalize(open)), 0.0, 0.0);
#endif
}
#endif

#ifdef BOUNCE
#ifdef BENT
layout(location = 2) out vec4 frag_gained;
#else
layout(location = 1) out vec4 frag_gained;
#endif

void ssao_write_gained(vec4 gained) {
#if BOUNCE == 1
    frag_gained = gained;
#else
    // Of next to none the mean is coarse, in half floats: it counts as much as it is known.
    frag_gained = vec4(gained.rgb / max(gained.a, 6e-8), clamp(1e3 * gained.a, 0.0, 1.0));
#endif
}
#endif
