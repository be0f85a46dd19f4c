// One bounce of a directional light from the texels of its shadow map: Dachsbacher & Stamminger, "Reflective Shadow Maps", I3D 2005.
// Irradiance over pi; lengths in units of the radius, in the axes of the light.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/srgb.glsl"
#include "lib/center_pixel.glsl"

uniform highp sampler2D u_shadow;   // see lib/shadow.glsl
uniform sampler2D u_shadow_normal;
uniform sampler2D u_shadow_color;
uniform mat4 u_shadow_place;
uniform mat2x3 u_shadow_sides;
uniform vec3 u_shadow_light;        // of the lamp, on what faces it
uniform vec2 u_taps[TAPS];          // unit vectors
uniform sampler2D u_turns;
uniform float u_own;                // share of a tap that is this pixel's, where a filter averages those of a tile
uniform float u_radius;             // scene units
uniform float u_noise_width;        // texels

// What a texel sends to a surface with normal n at the origin; away: from there to it. A disk of its size, which cannot send more than
// all, stands for what it shows: nearby the square of the distance is no divisor.
vec3 ssao_sent(ivec2 texel, vec3 away, vec3 n, float share) {
    vec3 n_p = ssao_decode_normal(texelFetch(u_shadow_normal, texel, 0).xy);
    float distance2 = dot(away, away);
    float facing = max(dot(n, away), 0.0) * max(-dot(n_p, away), 0.0) / max(distance2, 1e-12);
    float size = share * u_own / max(n_p.z, 0.02);  // flat light falls on more of a surface
    vec3 color = ssao_srgb_to_linear(texelFetch(u_shadow_color, texel, 0).rgb);
    return distance2 < 1.0 ? color * (share * facing / (distance2 + size)) : vec3(0.0);
}

void main() {
    SsaoPixel pixel = ssao_pixel();
    vec3 p = ssao_position(pixel.at * u_texel, max(pixel.z, 1e-30));
    vec3 noise = SAMPLE(u_turns, gl_FragCoord.xy / u_noise_width).xyz;
    vec3 at = (u_shadow_place * vec4(p, 1.0)).xyz;
    vec2 side = vec2(length(u_shadow_sides[0]), length(u_shadow_sides[1]));
    vec3 right = u_shadow_sides[0] / side.x, up = u_shadow_sides[1] / side.y;
    vec3 n = vec3(dot(pixel.n, right), dot(pixel.n, up), dot(pixel.n, cross(right, up)));
    vec2 size = vec2(textureSize(u_shadow, 0));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < TAPS; i++) {
        float ring = (float(i) + noise.z) / float(TAPS);
        vec2 texel = floor(at.xy + reflect(u_taps[i], noise.xy) * (ring * u_radius / side));
        if (texel != clamp(texel, vec2(0.0), size - 1.0)) continue;  // nobody knows what is lit there
        float z = texelFetch(u_shadow, ivec2(texel), 0).r;
        vec3 away = vec3((texel + 0.5 - at.xy) * side, at.z - z) / u_radius;
        sum += ssao_sent(ivec2(texel), clamp(away, -2.0, 2.0), n, 2.0 * ring / float(TAPS));
    }
    frag_color = vec4(pixel.z > 0.0 ? min(sum * u_shadow_light, 6e4) : vec3(0.0), 1.0);  // half floats end at 65504
}
