// The screen's visibility, corrected: by the residuals of the four nearest blocks that lie in the pixel's tangent plane, and by the
// pixel's own rays. See passes/residual.py.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/residual.glsl"

uniform sampler2D u_residual;
uniform sampler2D u_rays;
uniform sampler2D u_screen;
uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform vec2 u_small_texel;  // 1 / size of the blocks' image
uniform float u_per_pixel;   // 1 / (tolerance in pixels * size of a pixel at w = 1)
uniform float u_least;       // rays that weigh as much as none at all
uniform float u_own;         // rays of its own that weigh as much as the neighbours'

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r, screen = SAMPLE(u_screen, uv).r, rays = SAMPLE(u_rays, uv).r;
    vec2 normal = SAMPLE(u_normal, uv).xy;
    vec3 n = ssao_decode_normal(normal);
    float per_unit = u_per_pixel / max(ssao_w(z), 1e-30);
    float plane = dot(n, ssao_position(uv, z));
    vec2 at = 0.5 * gl_FragCoord.xy - 0.5, f = fract(at);
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 4; i++) {
        vec2 q = vec2(float(i & 1), float(i >> 1));
        vec2 block = floor(at) + q + 0.5;
        vec4 tap = SAMPLE(u_residual, block * u_small_texel);
        float off = abs(dot(n, ssao_position(2.0 * block * u_texel, tap.z)) - plane) * per_unit;
        float fits = tap.z > 0.0 ? clamp(2.0 - off, 0.0, 1.0) * ssao_alike(ssao_unpack_normal(tap.w), normal) : 0.0;
        vec2 near = mix(1.0 - f, f, q);
        sum += tap.xy * (fits * near.x * near.y);
    }
    float count = floor(rays), spread = sum.x / (sum.y + u_least);
    float own = count >= 1.0 ? 2.0 * (rays - count) - screen : 0.0;
    float more = (count * own + u_own * spread) / (count + u_own);
    frag_color = vec4(z > 0.0 ? clamp(screen + more, 0.0, 1.0) : 1.0);
}
