// Cones through the occupancy of the scene, after Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011:
// each step meets one voxel, of the level whose voxels are about as wide as the cone, and of the steps of a cone counts the one that
// hides most. Nothing here depends on the image but the noise.
#needs es300
precision highp sampler3D;
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/output.glsl"

uniform sampler3D u_field;     // shares that are filled, of the finest voxels; those at the border are empty
uniform sampler3D u_coarse;    // opacities along the axes, of larger ones
uniform sampler2D u_noise;     // (cos, sin) of the turn about the normal, place of a cone in its ring, place of steps
uniform float u_noise_width;   // pixels
uniform mat4 u_to_field;       // view space -> finest voxels, from one near the eye on: a scene that grows elsewhere changes no digit
uniform mat3 u_to_axes;        // and of directions, which stay of unit length
uniform mat4 u_least;          // first cell of each level, in columns
uniform mat4 u_last;           // and its last
uniform mat4 u_place;          // cells -> texels
uniform float u_apart;         // 0: what fills several voxels of a cone is one thing, 1: it is many small ones
uniform vec3 u_lift;           // of the tangent plane, in voxels: of the finest; of larger ones; and of those, of a plane across an axis
uniform vec4 u_steps[STEPS];   // distance and length in finest voxels, 1 / side of a voxel, share of the voxel that is gone through
uniform vec2 u_turns[CONES];   // (cos, sin) of each cone's angle about the normal

const float GOLDEN = 0.61803399;

// A cone: where it goes, and what it has met.
struct SsaoCone {
    vec3 d;        // its axis
    vec3 d2;       // and its squares
    float offset;  // place of steps, 0 to 1
    float most;    // hidden by one step
    float clear;   // left by all steps, were they apart
};

// Its cell among voxels that are s.z to the finest one, at step s.
vec3 ssao_cell(vec3 p, SsaoCone cone, vec4 s) { return floor((p + cone.d * (s.x + cone.offset * s.y)) * s.z); }

// The texel of a cell. What lies beside the grid becomes one at its border.
ivec3 ssao_texel(vec3 cell, int level) {
    return ivec3(clamp(cell, u_least[level].xyz, u_last[level].xyz) + u_place[level].xyz);
}

// Take in a voxel that hides `opacity`, but for the share `below` that lies below the tangent plane: it may be the surface's own.
void ssao_meet(inout SsaoCone cone, float opacity, float below, float share) {
    float hidden = share * max(opacity - max(below, 0.0), 0.0);
    cone.most = max(cone.most, hidden);
    cone.clear -= cone.clear * hidden;
}

void ssao_fine(inout SsaoCone cone, vec4 s, vec3 p, vec3 slope, vec2 plane) {
    vec3 cell = ssao_cell(p, cone, s);
    float below = plane.x + plane.y + u_lift.x - dot(slope, cell);
    ssao_meet(cone, texelFetch(u_field, ssao_texel(cell, 0), 0).r, below, s.w);
}

void ssao_coarser(inout SsaoCone cone, vec4 s, int level, vec3 p, vec3 slope, vec2 plane) {
    vec3 cell = ssao_cell(p, cone, s);
    float below = plane.x * s.z + plane.y - dot(slope, cell);
    ssao_meet(cone, dot(texelFetch(u_coarse, ssao_texel(cell, level), 0).rgb, cone.d2), below, s.w);
}

// How much of a cone is hidden.
float ssao_hidden(SsaoCone cone, vec3 p, vec3 slope, vec2 plane, vec2 coarse) {
#repeat STEPS_0 ssao_fine(cone, u_steps[@], p, slope, plane);
#repeat STEPS_1 ssao_coarser(cone, u_steps[STEPS_0 + @], 1, p, slope, coarse);
    if (cone.most > 0.99) return 1.0;
#repeat STEPS_2 ssao_coarser(cone, u_steps[STEPS_0 + STEPS_1 + @], 2, p, slope, coarse);
#repeat STEPS_3 ssao_coarser(cone, u_steps[STEPS_0 + STEPS_1 + STEPS_2 + @], 3, p, slope, coarse);
    return mix(cone.most, 1.0 - cone.clear, u_apart);
}

void main() {
    SsaoPixel pixel = ssao_pixel();
    vec3 p = (u_to_field * vec4(ssao_position(pixel.at * u_texel, max(pixel.z, 1e-30)), 1.0)).xyz;
    // Frame: Duff et al., "Building an Orthonormal Basis, Revisited", 2017. In view space: cones turn with the camera, as the noise does.
    vec3 n = pixel.n;
    float side = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;
    vec3 x = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), y = vec3(b, side + n.y * n.y * a, -n.y);
    vec4 noise = SAMPLE(u_noise, gl_FragCoord.xy / u_noise_width);
    vec3 right = u_to_axes * (noise.x * x + noise.y * y), up = u_to_axes * (noise.x * y - noise.y * x);
    n = u_to_axes * n;
    // Of a voxel lies below the plane about plane.x / its side + plane.y - dot(slope, its cell): a half when its middle lies on it.
    vec3 slope = n / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 plane = vec2(dot(slope, p), 0.5 - dot(slope, vec3(0.5)));
    // Along its axes an oblique shell hides less of a larger voxel than one that lies across an axis, but for its own thickness.
    float across = max(max(abs(slope.x), abs(slope.y)), abs(slope.z));
    vec2 coarse = plane + vec2(u_lift.z * (1.0 - across), u_lift.y + u_lift.z * across);
    float hidden = 0.0;
    for (int i = 0; i < CONES; i++) {
        float r2 = (float(i) + noise.z) / float(CONES);
        vec2 turn = u_turns[i] * sqrt(r2);
        vec3 d = turn.x * right + turn.y * up + sqrt(1.0 - r2) * n;
        hidden += ssao_hidden(SsaoCone(d, d * d, fract(noise.w + GOLDEN * float(i)), 0.0, 1.0), p, slope, plane, coarse);
    }
    ssao_write(1.0 - hidden / float(CONES), pixel.z);
}
