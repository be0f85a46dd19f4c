// For each block of BLOCK x BLOCK pixels, what bounds its surfaces from the front: affine functions of the place in the image.
// With a, b the slope of its nearest surface, their nearness (lib/inverse_depth.glsl) lies between a x + b y + low and a x + b y + high,
// x and y in pixels from the middle of the block. spread is how much the slope of any tangent plane is off, and any step from
// pixel to pixel; it is past all bounds where the block meets background.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/inverse_depth.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normal;
layout(location = 0) out vec4 out_bounds;  // a, b, low, high; high is -1e30 where there is only background
layout(location = 1) out vec4 out_spread;

const float MIDDLE = 0.5 * float(BLOCK);
const float NOTHING = 1e30;

// What a block gathers while it is read row by row.
struct SsaoGather {
    vec2 corner;   // centre of its first pixel
    vec2 last;     // centre of the last pixel of the image
    vec2 slope;
    float low;
    float high;
    vec2 step;
    float left;    // of the pixel before
    vec2 normal;   // encoded, of the nearest surface
    float turn2;   // square of the largest distance to it
};

// Pixel i of row j, given what was left of the one below; gives what is left of its own nearness.
float ssao_read(inout SsaoGather g, float i, float j, float below) {
    vec2 at = g.corner + vec2(i, j);
    float z = SAMPLE(u_z, at * u_texel).r;
    float off = z > 0.0 ? ssao_nearness(z) - dot(g.slope, vec2(i, j) + 0.5 - MIDDLE) : NOTHING;
    bool inside = at.x <= g.last.x && at.y <= g.last.y;
    // The row and the column beyond the block count for the steps that lead there.
    g.step.x = i > 0.0 && j < float(BLOCK) && inside ? max(g.step.x, abs(off - g.left)) : g.step.x;
    g.step.y = j > 0.0 && i < float(BLOCK) && inside ? max(g.step.y, abs(off - below)) : g.step.y;
    bool own = z > 0.0 && inside && i < float(BLOCK) && j < float(BLOCK);
    g.low = own ? min(g.low, off) : g.low;
    g.high = own ? max(g.high, off) : g.high;
    vec2 turn = SAMPLE(u_normal, at * u_texel).xy - g.normal;
    g.turn2 = own ? max(g.turn2, dot(turn, turn)) : g.turn2;
    g.left = off;
    return off;
}

void main() {
    SsaoGather g;
    g.corner = floor(gl_FragCoord.xy) * float(BLOCK) + 0.5;
    g.last = u_size - 0.5;
    // The nearest surface is what bounds the block from the front. A few pixels tell.
    float z = 0.0;
    vec2 uv = g.corner * u_texel;
    for (float j = 1.0; j < float(BLOCK); j += 4.0) {
        for (float i = 1.0; i < float(BLOCK); i += 4.0) {
            vec2 place = min(g.corner + vec2(i, j), g.last) * u_texel;
            float other = SAMPLE(u_z, place).r;
            bool nearer = other > 0.0 && (z <= 0.0 || other < z);
            z = nearer ? other : z;
            uv = nearer ? place : uv;
        }
    }
    g.normal = SAMPLE(u_normal, uv).xy;
    g.turn2 = 0.0;
    vec3 n = ssao_decode_normal(g.normal);
    g.slope = z > 0.0 ? ssao_slope(uv, z, n) : vec2(0.0);
    g.low = NOTHING;
    g.high = -NOTHING;
    g.step = vec2(0.0);
    float below[BLOCK + 1];
#repeat BELOW below[@] = NOTHING;
    for (float j = 0.0; j <= float(BLOCK); j += 1.0) {
        g.left = NOTHING;
#repeat BELOW below[@] = ssao_read(g, float(@), j, below[@]);
    }
    // From how far normals turn (their encoding stretches by sqrt 2 at most) to how far n / (n . P), and with it slopes, do.
    vec3 ray = vec3(u_ray * uv + u_ray0, -1.0);
    float turn = 1.5 * sqrt(g.turn2), toward = abs(dot(n, ray)), slant = length(ray);
    float away = turn * (1.0 + slant / max(toward - slant * turn, 1e-3 * slant)) / max(toward, 1e-3 * slant);
    vec2 spread = away * (u_w.x > 0.0 ? vec2(length(u_ray[0]), length(u_ray[1])) / max(z, 1e-30)
                                      : vec2(length(u_org[0]), length(u_org[1]))) * u_texel;
    bool empty = g.high < -0.5 * NOTHING;
    out_bounds = empty ? vec4(0.0, 0.0, NOTHING, -NOTHING) : vec4(g.slope, g.low, g.high);
    out_spread = vec4(spread, g.step);
}
