// The range of nearness over BLOCK x BLOCK texels, as (highest, -lowest); both far below all others where there is nothing.
#needs es300
#include "lib/view.glsl"
#include "lib/inverse_depth.glsl"

uniform sampler2D u_source;  // with SCALE linear depth of the image, of which every SCALE-th pixel counts; else ranges

vec2 ssao_range(ivec2 texel) {
#ifdef SCALE
    float z = texelFetch(u_source, min(texel * SCALE, textureSize(u_source, 0) - 1), 0).r;
    return z > 0.0 ? vec2(ssao_nearness(z), -ssao_nearness(z)) : vec2(-1e37);
#else
    return texelFetch(u_source, min(texel, textureSize(u_source, 0) - 1), 0).rg;
#endif
}

void main() {
    ivec2 corner = ivec2(gl_FragCoord.xy) * BLOCK;
    vec2 most = vec2(-1e37);
    for (int j = 0; j < BLOCK; j++) {
        for (int i = 0; i < BLOCK; i++) most = max(most, ssao_range(corner + ivec2(i, j)));
    }
    frag_color = vec4(most, 0.0, 0.0);
}
