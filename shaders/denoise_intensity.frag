// The lecture's bilateral filter: Gaussian in space times Gaussian in intensity, normalised. In 2-D with WIDTH and
// HEIGHT both the radius; one of them 0 makes an axis of the separable approximation.
#needs es300
#include "lib/output.glsl"

uniform vec2 u_texel;
uniform sampler2D u_packed;   // visibility and linear depth
uniform float u_weights[RADIUS + 1];
uniform float u_range;        // 1 / (2 sigma^2)

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    vec2 here = ssao_unpack(SAMPLE(u_packed, uv).r);
    vec2 sum = vec2(0.0);
    for (int y = -HEIGHT; y <= HEIGHT; y++) {
        for (int x = -WIDTH; x <= WIDTH; x++) {
            vec2 tap = ssao_unpack(SAMPLE(u_packed, uv + vec2(x, y) * u_texel).r);
            float delta = tap.x - here.x;
            float weight = u_weights[abs(x)] * u_weights[abs(y)] * exp(-u_range * delta * delta);
            sum += tap.y > 0.0 ? vec2(tap.x, 1.0) * weight : vec2(0.0);  // background never mixes in
        }
    }
    float visibility = sum.y > 0.0 ? sum.x / sum.y : here.x;
#ifdef LAST
    frag_color = vec4(here.y > 0.0 ? visibility : 1.0);
#else
    frag_color = vec4(ssao_pack(visibility, here.y));
#endif
}
