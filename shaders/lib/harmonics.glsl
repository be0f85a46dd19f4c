// Light from all around as spherical harmonics up to band 2; see scene/harmonics.py. Without SKY it is the same from everywhere.
#ifdef SKY
uniform vec3 u_sky[9];
uniform mat3 u_sky_from_view;
#else
uniform vec3 u_sky_even;
#endif

// By how much bands 1 and 2 are weaker in what a surface receives over pi: Ramamoorthi, Hanrahan 2001.
const vec2 SSAO_MATT = vec2(2.0 / 3.0, 0.25);

// What comes from around a direction, whose lobe weakens the bands.
vec3 ssao_sky(vec3 direction, vec2 bands) {
#ifdef SKY
    vec3 d = u_sky_from_view * direction;
    vec3 first = u_sky[1] * d.y + u_sky[2] * d.z + u_sky[3] * d.x;
    vec3 second = u_sky[4] * (d.x * d.y) + u_sky[5] * (d.y * d.z) + u_sky[6] * (3.0 * d.z * d.z - 1.0) + u_sky[7] * (d.x * d.z)
        + u_sky[8] * (d.x * d.x - d.y * d.y);
    return max(u_sky[0] + bands.x * first + bands.y * second, 0.0);
#else
    return u_sky_even;
#endif
}

// The bands of a mirror's lobe: a heat kernel, which comes close to the matt one where it is rough.
vec2 ssao_blurred(float roughness) {
    float t = mix(0.05, 0.2, roughness);
    return exp(vec2(-2.0, -6.0) * t);
}
