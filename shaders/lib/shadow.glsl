// Shadows of a directional light by its map, whose texels hold the distance along the light of what it meets first.
uniform highp sampler2D u_shadow;
uniform mat4 u_shadow_place;   // from view space to (texels, texels, distance)
uniform mat2x3 u_shadow_sides; // of a texel, view space
uniform float u_shadow_texel;  // the longer of them, scene units

// What lies nearer than this is the surface itself: texels, and texels a texel aside.
const vec2 SSAO_SHADOW_BIAS = vec2(0.5, 1.0);

// How much of a light in direction `to` reaches p. Each texel is compared with the receiver's own plane below its middle, so a plane
// has no acne however flat the light falls; the nine are weighted by a quadratic B-spline, so shadows have no steps.
float ssao_lit(vec3 p, vec3 n, vec3 to) {
    float facing = dot(n, to);
    if (facing <= 0.0) return 0.0;
    vec3 at = (u_shadow_place * vec4(p, 1.0)).xyz;
    ivec2 size = textureSize(u_shadow, 0), middle = ivec2(floor(at.xy));
    vec2 offset = vec2(middle) + 0.5 - at.xy;
    vec2 slope = (n * u_shadow_sides) / max(facing, 0.01);
    // Normals in half floats: a slope is known less the steeper it is.
    float known = u_shadow_texel * (1.0 + 1e-3 / max(facing * facing, 1e-4));
    float sum = 0.0;
    for (int y = -1; y <= 1; y++) {
        for (int x = -1; x <= 1; x++) {
            vec2 aside = offset + vec2(x, y);
            vec2 near = max(1.5 - abs(aside), 0.0), inner = max(0.5 - abs(aside), 0.0);
            vec2 weight = 0.5 * near * near - 1.5 * inner * inner;
            float first = texelFetch(u_shadow, clamp(middle + ivec2(x, y), ivec2(0), size - 1), 0).r;
            float own = at.z + dot(slope, aside) - known * (SSAO_SHADOW_BIAS.x + SSAO_SHADOW_BIAS.y * length(aside));
            sum += first < own ? 0.0 : weight.x * weight.y;
        }
    }
    return clamp(sum, 0.0, 1.0);
}
