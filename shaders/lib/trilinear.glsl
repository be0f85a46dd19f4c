// The field of a volume between its voxels, and rays through it. Coordinates are those of the field's texture: its first
// voxel, one of the ring of padding, lies at 0, and cell c between voxels c and c + 1. Voxels are fetched and blended
// here: 32-bit floats are not filtered by every driver, and filters of GPUs know 256 places between two texels.
uniform highp sampler3D u_field;
uniform highp sampler3D u_leaps;  // scene/proximity.py: of each cell, over 255
uniform vec3 u_first;              // first and end of the cells that may hold what is seen
uniform vec3 u_end;

// f(q) = k.x x + k.y y + k.z z + one + m.x y z + m.y x z + m.z x y + all x y z, with q in 0..1
struct Cell {
    float one;
    vec3 k;
    vec3 m;
    float all;
};

float ssao_voxel(ivec3 at) { return texelFetch(u_field, at, 0).r; }

Cell ssao_cell(vec3 cell) {
    ivec3 at = ivec3(cell);
    float a = ssao_voxel(at), b = ssao_voxel(at + ivec3(1, 0, 0));
    float c = ssao_voxel(at + ivec3(0, 1, 0)), d = ssao_voxel(at + ivec3(1, 1, 0));
    float e = ssao_voxel(at + ivec3(0, 0, 1)), f = ssao_voxel(at + ivec3(1, 0, 1));
    float g = ssao_voxel(at + ivec3(0, 1, 1)), h = ssao_voxel(at + ivec3(1, 1, 1));
    vec3 k = vec3(b, c, e) - a;
    vec3 m = vec3((g - e) - (c - a), (f - e) - (b - a), (d - c) - (b - a));
    return Cell(a, k, m, ((h - g) - (f - e)) - ((d - c) - (b - a)));
}

float ssao_value(Cell cell, vec3 q) {
    return cell.one + dot(cell.k, q) + dot(cell.m, q.yxx * q.zzy) + cell.all * q.x * q.y * q.z;
}

vec3 ssao_cell_gradient(Cell cell, vec3 q) {
    return cell.k + cell.m.zzy * q.yxx + cell.m.yxx * q.zzy + cell.all * q.yxx * q.zzy;
}

vec3 ssao_cell_of(vec3 p) { return clamp(floor(p), vec3(0.0), vec3(textureSize(u_field, 0) - 2)); }

float ssao_field(vec3 p) {
    vec3 cell = ssao_cell_of(p);
    return ssao_value(ssao_cell(cell), clamp(p - cell, 0.0, 1.0));
}

// Central differences of voxels, blended: continuous from cell to cell, as normals for light should be.
vec3 ssao_smooth_gradient(vec3 p) {
    vec2 h = vec2(1.0, 0.0);
    return 0.5 * vec3(ssao_field(p + h.xyy) - ssao_field(p - h.xyy), ssao_field(p + h.yxy) - ssao_field(p - h.yxy),
                      ssao_field(p + h.yyx) - ssao_field(p - h.yyx));
}

// Along q + u e, u in 0..1, the field is a cubic: coefficients of u^3, u^2, u, 1.
vec4 ssao_cubic(Cell cell, vec3 q, vec3 e) {
    vec3 ee = e.yxx * e.zzy;
    float cubic = cell.all * e.x * e.y * e.z;
    float square = dot(cell.m, ee) + cell.all * dot(q, ee);
    return vec4(cubic, square, dot(ssao_cell_gradient(cell, q), e), ssao_value(cell, q));
}

float ssao_at(vec4 c, float u) { return ((c.x * u + c.y) * u + c.z) * u + c.w; }

// The ends of the first part of 0..1, between extrema, over which the cubic changes from its side of 0 at 0 to the other;
// x > y where there is none (Marmitt et al. 2004, "Fast and Accurate Ray-Voxel Intersection Techniques").
vec2 ssao_bracket(vec4 c) {
    bool inside = c.w >= 0.0;
    float half_b = c.y, root2 = half_b * half_b - 3.0 * c.x * c.z;  // 3 c.x u^2 + 2 c.y u + c.z = 0
    float first = 1.0, second = 1.0;
    if (root2 > 0.0) {
        float q = -(half_b + (half_b < 0.0 ? -1.0 : 1.0) * sqrt(root2));  // without cancellation
        float a = abs(3.0 * c.x) * 1e6 > abs(q) ? q / (3.0 * c.x) : 1.0;
        float b = abs(q) > 0.0 ? c.z / q : 1.0;
        first = clamp(min(a, b), 0.0, 1.0);
        second = clamp(max(a, b), 0.0, 1.0);
    }
    if ((ssao_at(c, first) >= 0.0) != inside) return vec2(0.0, first);
    if ((ssao_at(c, second) >= 0.0) != inside) return vec2(first, second);
    if ((ssao_at(c, 1.0) >= 0.0) != inside) return vec2(second, 1.0);
    return vec2(1.0, 0.0);
}

// Where a cubic that is monotone over the bracket crosses 0: regula falsi, halving the weight of an end that stays (Illinois).
float ssao_root(vec4 c, vec2 ends) {
    vec2 f = vec2(ssao_at(c, ends.x), ssao_at(c, ends.y));
    float kept = 0.0;
    for (int i = 0; i < 10; i++) {
        float rise = f.y - f.x;
        if (rise == 0.0) break;
        float u = clamp(ends.x - f.x * (ends.y - ends.x) / rise, ends.x, ends.y), fu = ssao_at(c, u);
        if ((fu >= 0.0) == (f.y >= 0.0)) {
            ends.y = u;
            f = vec2(kept > 0.0 ? 0.5 * f.x : f.x, fu);
            kept = 1.0;
        } else {
            ends.x = u;
            f = vec2(fu, kept < 0.0 ? 0.5 * f.y : f.y);
            kept = -1.0;
        }
    }
    float rise = f.y - f.x;
    return rise == 0.0 ? ends.x : clamp(ends.x - f.x * (ends.y - ends.x) / rise, ends.x, ends.y);
}

// What a ray sees: where, in steps along it, in which cell, of which colour (sRGB).
struct Seen {
    bool found;
    float s;
    vec3 cell;
    vec3 color;
};

// A block of cells of which all are on one side of the surface, or a single one through which it may go.
struct Leap {
    vec3 low;
    float size;
    bool one_sided;
    bool inside;
};

Leap ssao_leap(vec3 cell) {
    float code = floor(texelFetch(u_leaps, ivec3(cell), 0).r * 255.0 + 0.5);
    bool inside = code >= 128.0;
    float away = inside ? code - 128.0 : code, reach = max(away - 1.0, 0.0);
    return Leap(cell - reach, 2.0 * reach + 1.0, away > 0.0, inside);
}

// The cell after a block, which a ray leaves at `next`, `last` at most (Amanatides & Woo 1987, "A Fast Voxel Traversal Algorithm
// for Ray Tracing"). The axis along which it leaves decides by whole numbers, so rounding never leads back.
vec3 ssao_beyond(vec3 start, vec3 along, vec3 inverse, vec3 forward, Leap leap, float s, float last, out float next) {
    vec3 leaves = (leap.low + leap.size * forward - start) * inverse;
    next = max(min(min(leaves.x, leaves.y), min(leaves.z, last)), s);
    vec3 beside = clamp(floor(start + next * along), leap.low, leap.low + leap.size - 1.0);
    return mix(beside, leap.low + mix(vec3(-1.0), vec3(leap.size), forward), lessThanEqual(leaves, vec3(next)));
}

bool ssao_left(vec3 cell) { return any(lessThan(cell, u_first)) || any(greaterThanEqual(cell, u_end)); }
