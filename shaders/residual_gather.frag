// Residuals of a block of 2x2 pixels: those rays' that start on the surface of the first of them. Its depth is that of its tangent
// plane at the middle of the block, so that texels lie on a regular grid.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/residual.glsl"

uniform sampler2D u_rays;     // number of rays + half of their visibility
uniform sampler2D u_screen;   // visibility of the screen
uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)

// The middle of a pixel of the block.
vec2 ssao_place(vec2 corner, int i) { return (corner + vec2(float(i & 1), float(i >> 1)) + 0.5) * u_texel; }

void main() {
    vec2 corner = 2.0 * floor(gl_FragCoord.xy);
    vec4 rays = vec4(0.0), depth = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        vec2 uv = ssao_place(corner, i);
        bool inside = max(uv.x, uv.y) < 1.0;  // the last block of an odd image has pixels beside it
        rays[i] = inside ? SAMPLE(u_rays, uv).r : 0.0;
        depth[i] = inside ? SAMPLE(u_z, uv).r : 0.0;
    }
    // The first pixel with a ray, else the first that shows a surface; another of the four comes first in each block.
    int turn = (int(gl_FragCoord.x) + 2 * int(gl_FragCoord.y)) & 3, chosen = -1, seen = -1;
    for (int i = 3; i >= 0; i--) {
        int k = (i + turn) & 3;
        seen = depth[k] > 0.0 ? k : seen;
        chosen = depth[k] > 0.0 && rays[k] >= 1.0 ? k : chosen;
    }
    chosen = chosen < 0 ? seen : chosen;
    frag_color = vec4(0.0);
    if (chosen < 0) return;
    vec2 uv = ssao_place(corner, chosen);
    vec2 encoded = SAMPLE(u_normal, uv).xy;
    vec3 n = ssao_decode_normal(encoded);
    float z = depth[chosen];
    float plane = dot(n, ssao_position(uv, z));
    float per_unit = u_per_pixel / max(ssao_w(z), 1e-30);
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 4; i++) {
        vec2 place = ssao_place(corner, i);
        float off = abs(dot(n, ssao_position(place, depth[i])) - plane) * per_unit;
        float count = floor(rays[i]);
        float fits = count >= 1.0 && depth[i] > 0.0 ? clamp(2.0 - off, 0.0, 1.0) : 0.0;
        float open = 2.0 * (rays[i] - count);
        sum += fits * count * vec2(open - SAMPLE(u_screen, place).r, 1.0);
    }
    vec2 middle = (corner + 1.0) * u_texel;
    float slope = dot(n.xy, u_ray * middle + u_ray0) - n.z;
    float met = (plane - dot(n.xy, u_org * middle + u_org0)) / (abs(slope) > 1e-6 ? slope : 1e-6);
    frag_color = vec4(sum, met > 0.5 * z && met < 2.0 * z ? met : z, ssao_pack_normal(encoded));
}
