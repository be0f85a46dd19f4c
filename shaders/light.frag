// The picture under lamps and light from all around: base colour times what falls on it, and what shines, in linear light.
// Occlusion dims the light from all around alone; lamps have shadows.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/srgb.glsl"
#include "lib/harmonics.glsl"
#include "lib/lamps.glsl"
#ifdef SPECULAR
#include "lib/specular.glsl"
#endif
#ifdef TONE
#include "lib/tone.glsl"
#endif

uniform sampler2D u_color;       // sRGB
uniform sampler2D u_visibility;
uniform sampler2D u_normal;      // for shading
uniform sampler2D u_z;
#ifdef BENT_SKY
uniform sampler2D u_bent;        // mean open direction
#endif
#ifdef BOUNCED
uniform sampler2D u_gained;      // mean of what hides the pixel, and whether some of it is seen; BOUNCED 2: what reaches it of it
uniform float u_hidden_sky;      // see bounce.frag
#endif
#ifdef SPECULAR
uniform sampler2D u_material;    // roughness, metalness, whether it shines at all
uniform float u_specular;
#endif

#ifdef TONED
uniform float u_power;           // contrast of visibility
uniform vec3 u_tint;             // share of the light from all around that is left where all is hidden
#endif

#ifdef TINT
// Light that bounced between surfaces of one colour, as visibility that depends on it: Jimenez et al., "Practical Realtime Strategies
// for Accurate Indirect Occlusion", 2016.
vec3 ssao_tinted(float visibility, vec3 color) {
    vec3 a = 2.0404 * color - 0.3324, b = -4.7951 * color + 0.6417, c = 2.7552 * color + 0.6903;
    return max(vec3(visibility), ((visibility * a + b) * visibility + c) * visibility);
}
#endif

#ifdef SPECULAR
// What shines: of the environment as far as the open cone sees it, and of the lamps.
vec3 ssao_shiny(Shine shine, float visibility, vec3 open, vec3 n, vec3 p, float first) {
    float seen = ssao_specular_visibility(visibility, open, n, shine);
    vec3 sum = shine.albedo * seen * ssao_sky(shine.mirrored, ssao_blurred(shine.roughness));
#if LAMPS > 0
    for (int i = 0; i < LAMPS; i++) {
        vec3 to;
        vec3 light = ssao_lamp(i, p, to) * (max(dot(n, to), 0.0) * (i == 0 ? first : 1.0));
        if (light != vec3(0.0)) sum += light * ssao_ggx(shine, n, to);
    }
#endif
    return sum;
}
#endif

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    vec3 color = ssao_srgb_to_linear(SAMPLE(u_color, uv).rgb);
    float visibility = SAMPLE(u_visibility, uv).r;
#ifdef TONED
    visibility = pow(max(visibility, 1e-4), u_power);
#endif
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
#ifdef BENT_SKY
    vec3 open = ssao_decode_normal(SAMPLE(u_bent, uv).xy);
#else
    vec3 open = n;
#endif
#if LAMPS > 0 || defined(SPECULAR)
    vec3 p = ssao_position(uv, max(SAMPLE(u_z, uv).r, 1e-30));
#endif
#ifdef TINT
    vec3 dimmed = ssao_tinted(visibility, color);
#else
    vec3 dimmed = vec3(visibility);
#endif
#ifdef TONED
    dimmed = mix(u_tint, vec3(1.0), dimmed);
#endif
    vec3 matt = dimmed * ssao_sky(open, SSAO_MATT);
    float first = 1.0;
    vec3 lamps = vec3(0.0);
#if LAMPS > 0
    first = ssao_first_lamp(uv, p);
    lamps = ssao_lamps(p, n, first);
    matt += lamps;
#endif
#if defined(BOUNCED) && BOUNCED == 2
    matt += SAMPLE(u_gained, uv).rgb;
#elif defined(BOUNCED)
    // What is hidden, and whose light nobody has seen, shines like what was seen; like the pixel itself where that is nothing.
    vec4 gained = SAMPLE(u_gained, uv);
    float hidden = 1.0 - visibility;
    vec3 own = color * (lamps + ssao_sky(n, SSAO_MATT) * (1.0 - hidden * u_hidden_sky));
    matt += hidden * mix(own, gained.rgb, gained.a);
#endif
    vec3 light = color * matt;
#ifdef SPECULAR
    vec3 material = SAMPLE(u_material, uv).rgb;
    if (material.z > 0.0) {
        Shine shine = ssao_shine(material, color, n, ssao_to_viewer(p));
        vec3 both = light * ((1.0 - material.y) * (1.0 - shine.lost)) + ssao_shiny(shine, visibility, open, n, p, first);
        light = mix(light, both, u_specular);
    }
#endif
#ifdef TONE
    light = ssao_tone(light);
#endif
    frag_color = vec4(ssao_linear_to_srgb(clamp(light, 0.0, 1.0)), 1.0);
}
