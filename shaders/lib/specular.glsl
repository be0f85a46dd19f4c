// What shines: the microfacets of glTF 2.0 (appendix B), and what of a mirror image the bent cone sees.
struct Shine {
    float roughness;   // perceptual
    vec3 base;         // reflectance straight on
    vec3 albedo;       // under light from all around
    float lost;        // what a matt layer below does not receive
    float facing;      // cosine to the viewer
    vec3 view, mirrored;
};

// material: roughness, metalness. The albedo is a fit: Lazarov, "Getting More Physical in Call of Duty: Black Ops II", 2013, by Karis 2014.
Shine ssao_shine(vec3 material, vec3 color, vec3 n, vec3 view) {
    Shine shine;
    shine.roughness = clamp(material.x, 0.05, 1.0);
    shine.view = view;
    shine.facing = max(dot(n, view), 1e-3);
    shine.mirrored = reflect(-view, n);
    shine.base = mix(vec3(0.04), color, material.y);
    vec4 r = shine.roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float grazing = min(r.x * r.x, exp2(-9.28 * shine.facing)) * r.x + r.y;
    vec2 split = vec2(-1.04, 1.04) * grazing + r.zw;
    // What bounces more than once between the facets is not lost: Fdez-Aguera, "A Multiple-Scattering Microfacet Model", 2019.
    float again = 1.0 / clamp(split.x + split.y, 0.1, 1.0) - 1.0;
    shine.albedo = clamp((shine.base * split.x + split.y) * (1.0 + shine.base * again), 0.0, 1.0);
    shine.lost = clamp((0.04 * split.x + split.y) * (1.0 + 0.04 * again), 0.0, 1.0);
    return shine;
}

// pi times the reflection of light from `to`: GGX, Smith's height-correlated masking (Heitz 2014), Schlick's Fresnel.
vec3 ssao_ggx(Shine shine, vec3 n, vec3 to) {
    vec3 h = normalize(shine.view + to + 1e-5 * n);
    float a = shine.roughness * shine.roughness, a2 = a * a;
    float nh = clamp(dot(n, h), 0.0, 1.0), nl = clamp(dot(n, to), 1e-3, 1.0), nv = shine.facing;
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float masked = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    float fresnel = pow(1.0 - clamp(dot(shine.view, h), 0.0, 1.0), 5.0);
    return (shine.base + (1.0 - shine.base) * fresnel) * (0.5 * a2 / max(d * d * masked, 1e-7));
}

// The part of a cap (cosine of its half angle) that another one has in common with it, by the angle between their axes; a smooth
// fit: Oat, Sander, "Ambient Aperture Lighting", 2007.
float ssao_common(float one, float other, float between) {
    float a = acos(one), b = acos(other), apart = abs(a - b);
    float share = 1.0 - clamp((between - apart) / max(a + b - apart, 1e-4), 0.0, 1.0);
    return share * share * (3.0 - 2.0 * share) * (1.0 - max(one, other));
}

// How much of the lobe about the mirrored direction the open cone sees, over what the whole hemisphere would: Jimenez et al., "Practical Realtime Strategies for Accurate
// Indirect Occlusion", 2016. The cone has the open directions' mean and their cosine-weighted share.
float ssao_specular_visibility(float visibility, vec3 open, vec3 n, Shine shine) {
    float cone = sqrt(clamp(1.0 - visibility, 0.0, 1.0));
    float lobe = exp2(-3.32193 * shine.roughness * shine.roughness);
    float seen = ssao_common(cone, lobe, acos(clamp(dot(open, shine.mirrored), -1.0, 1.0)));
    float most = ssao_common(0.0, lobe, acos(clamp(dot(n, shine.mirrored), -1.0, 1.0)));
    return clamp(seen / max(most, 1e-4), 0.0, 1.0);
}
