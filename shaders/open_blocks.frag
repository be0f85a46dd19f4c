// Which blocks are open: where all that is near enough to count lies on or behind the tangent plane of every pixel of the block,
// or so little above it that it hides no sector. Conservative, from the bounds of blocks (bounds.frag) alone.
//
// A point of nearness A, so many pixels from one whose tangent plane has the nearness g there, stands above that plane by
// |n . P| z (A - g), and is at least as far away as the two rays of sight are. Its elevation above the plane hides nothing up
// to LEVEL: a sector is hidden when half of it is, and the outermost of 32 begins at sqrt(2 / 64).
#needs es300
#include "lib/view.glsl"
#include "lib/inverse_depth.glsl"

uniform sampler2D u_bounds;
uniform sampler2D u_spread;
uniform vec2 u_block_texel;   // 1 / size of the image of blocks
uniform vec2 u_blocks;        // that size
uniform float u_radius;       // of the taps on the image, scene units
uniform float u_farthest;     // of what darkens: a tap may meet something that is farther away, scene units
uniform float u_max_radius;   // pixels
uniform float u_pixel;        // size of a pixel at w = 1, its smaller side, scene units

const float LEVEL = 0.16;

// What is known of the block in question.
struct SsaoBlock {
    vec2 here;      // its place among the blocks
    vec4 bounds;
    vec4 spread;
    float nearest;  // linear depth
    vec3 ray;       // of its middle, to depth 1
    float slant;    // length of every ray within reach, at most, about
    float allowed;  // how far nearness may exceed that of the tangent planes, for each pixel between
};

// The least and the largest linear depth of nearness in low .. high.
vec2 ssao_depths(float low, float high) {
    return u_w.x > 0.0 ? 1.0 / max(vec2(high, low), 1e-30) : -vec2(high, low);
}

// Whether all of another block, so many pixels aside, is too far away to count: its rays of sight pass that far, and
// along them it is that much nearer to the viewer.
bool ssao_beyond(SsaoBlock block, vec4 other, float between) {
    float lean = 0.5 * float(BLOCK) * (abs(other.x) + abs(other.y));
    vec2 depths = ssao_depths(other.z - lean, other.w + lean);
    float across = u_pixel * ssao_w(depths.x) * between / block.slant;
    float drift = u_pixel * ssao_w(depths.y) * (between + 3.0 * float(BLOCK)) * length(block.ray.xy) / length(block.ray);
    float along = max(0.0, (block.nearest - depths.y) * length(block.ray) - drift);
    return across * across + along * along > 1.02 * u_farthest * u_farthest;
}

// Whether the block at offset blocks from this one may hide something from it.
bool ssao_hides(SsaoBlock block, vec2 offset) {
    vec2 place = (block.here + offset) * u_block_texel;
    vec4 other = SAMPLE(u_bounds, place);
    vec2 turn = abs(other.xy - block.bounds.xy);
    vec2 aside = float(BLOCK) * abs(offset);
    float above = other.w - block.bounds.z - float(BLOCK) * dot(block.bounds.xy, offset)
        + 0.5 * float(BLOCK) * (turn.x + turn.y) + dot(block.spread.xy, aside + float(BLOCK));
    float between = max(length(max(aside - float(BLOCK) + 1.0, 0.0)), 1.0);
    bool hides = above > block.allowed * between;
    if (max(abs(offset.x), abs(offset.y)) < 1.5) {  // it touches: from pixel to pixel the surface leaves the tangent planes by so much at most
        vec4 spread = max(SAMPLE(u_spread, place), block.spread);
        vec2 steps = turn + max(spread.xy, spread.zw) + block.spread.xy;
        hides = hides && steps.x + steps.y > block.allowed;
    }
    return hides && other.w > -1e29 && !ssao_beyond(block, other, between);
}

void main() {
    SsaoBlock block;
    block.here = gl_FragCoord.xy;
    block.bounds = SAMPLE(u_bounds, block.here * u_block_texel);
    block.spread = SAMPLE(u_spread, block.here * u_block_texel);
    bool open = true;
    if (block.bounds.w > -1e29) {
        bool parallel = !(u_w.x > 0.0);
        float lean = 0.5 * float(BLOCK) * (abs(block.bounds.x) + abs(block.bounds.y));
        vec2 depths = ssao_depths(block.bounds.z - lean, block.bounds.w + lean);
        block.nearest = depths.x;
        vec2 uv = block.here * float(BLOCK) * u_texel;
        block.ray = vec3(u_ray * uv + u_ray0, -1.0);
        block.slant = 1.1 * length(block.ray);
        // n / (n . P), or n / (n . ray) in a parallel projection, from how nearness changes over the image.
        vec2 across = (block.bounds.xy * u_size) * inverse(parallel ? u_org : u_ray);
        float tilt = length(vec3(across, dot(across, block.ray.xy) - (parallel ? 1.0 : block.bounds.w)));
        float pixel = u_pixel * ssao_w(depths.x);
        block.allowed = LEVEL * pixel / block.slant * tilt / (parallel ? 1.0 : depths.y + u_farthest);
        float reach = min(u_radius * block.slant / max(pixel, 1e-30), u_max_radius) + 2.0;
        int n = int(ceil((reach - 1.0) / float(BLOCK)));
        vec2 first = max(vec2(-n), 0.5 - block.here), last = min(vec2(n), u_blocks - 0.5 - block.here);
        // Outwards in squares: what hides is mostly near.
        for (int r = 0; r <= n && open; r++) {
            for (int k = -r; k < r + (r == 0 ? 1 : 0) && open; k++) {
                vec2 edge = vec2(float(k), float(r));
                for (int side = 0; side < 4; side++) {
                    bool inside = all(greaterThanEqual(edge, first)) && all(lessThanEqual(edge, last));
                    if (inside && ssao_hides(block, edge)) open = false;
                    edge = vec2(edge.y, -edge.x);
                }
            }
        }
    }
    frag_color = vec4(open ? 1.0 : 0.0);
}
