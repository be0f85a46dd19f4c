// What a pixel reflects of lamps and of an open environment; in alpha which share of it is the environment's, and is dimmed where it
// is gathered.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/srgb.glsl"
#include "lib/harmonics.glsl"
#include "lib/lamps.glsl"

uniform sampler2D u_color;
uniform sampler2D u_normal;
uniform sampler2D u_z;
uniform float u_hidden_sky;  // 1: what reflects the environment sees as little of it as what gathers that; 0: it sees all
uniform vec2 u_target_uv;    // uv of the image for each fragment of the target

void main() {
    vec2 uv = gl_FragCoord.xy * u_target_uv;
    vec3 n = ssao_decode_normal(SAMPLE(u_normal, uv).xy);
    vec3 lamps = vec3(0.0);
#if LAMPS > 0
    // The place of the pixel that is read there.
    vec3 p = ssao_position((floor(uv * u_size) + 0.5) * u_texel, max(SAMPLE(u_z, uv).r, 1e-30));
    lamps = ssao_lamps(p, n, ssao_first_lamp(uv, p));
#endif
    vec3 sky = ssao_sky(n, SSAO_MATT), sum = lamps + sky;
    float share = dot(sky, vec3(1.0)) / max(dot(sum, vec3(1.0)), 1e-30);
    vec3 color = ssao_srgb_to_linear(SAMPLE(u_color, uv).rgb);
    frag_color = vec4(min(color * sum, 6e4), clamp(u_hidden_sky * share, 0.0, 1.0));  // half floats end at 65504
}
