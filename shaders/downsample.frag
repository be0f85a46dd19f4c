// A smaller image of depth and normals: of SCALE x SCALE pixels the first is kept, unless there is an edge of depth among them:
// then the nearest and the farthest take turns like a checkerboard, so that both sides are there. Background counts only
// where there is nothing else.
#needs es300
#include "lib/view.glsl"
uniform float u_edge;  // the depth that makes an edge, for each unit of w
uniform sampler2D u_z;
uniform sampler2D u_normal;
layout(location = 0) out vec4 out_z;
layout(location = 1) out vec4 out_normal;
#ifdef OPEN
#include "lib/output.glsl"
uniform sampler2D u_open;
uniform vec2 u_per_block;  // blocks for each pixel, as uv of their image
layout(location = 2) out vec4 out_raw;  // open where nothing is to be drawn
#endif

// Pixel number i below a fragment, as an offset from its corner.
vec2 ssao_place(float i) { return vec2(mod(i, float(SCALE)), floor(i / float(SCALE))); }

// The better of what was found so far, (depth, number), and pixel number i; those outside the image are none. farther is 1
// where the farthest is wanted, -1 for the nearest.
vec2 ssao_better(vec2 best, vec2 corner, float i, float farther) {
    vec2 uv = (corner + ssao_place(i) + 0.5) * u_texel;
    float z = uv.x < 1.0 && uv.y < 1.0 ? SAMPLE(u_z, uv).r : 0.0;
    return z > 0.0 && (best.x <= 0.0 || (z - best.x) * farther > u_edge * ssao_w(z)) ? vec2(z, i) : best;
}

void main() {
    vec2 fragment = floor(gl_FragCoord.xy);
    vec2 corner = fragment * float(SCALE);
    float farther = mod(fragment.x + fragment.y, 2.0) < 0.5 ? -1.0 : 1.0;
    vec2 best = vec2(0.0);
#repeat PIXELS best = ssao_better(best, corner, float(@), farther);
    vec2 which = ssao_place(best.y);
    uint bits = (floatBitsToUint(best.x) & 0xFFFFFFF0u) | uint(which.x) | uint(which.y) << 2u;
    out_z = vec4(best.x > 0.0 ? uintBitsToFloat(bits) : 0.0);
    out_normal = SAMPLE(u_normal, (corner + which + 0.5) * u_texel);
    gl_FragDepth = best.x > 0.0 ? 0.0 : 1.0;
#ifdef OPEN
    out_raw = vec4(ssao_pack(1.0, best.x));
    if (best.x > 0.0 && SAMPLE(u_open, (corner + 0.5) * u_per_block).r > 0.5) gl_FragDepth = gl_FragCoord.z;
#endif
}
