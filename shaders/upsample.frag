// Visibility of a smaller image at full size: the four nearest of its texels, by how near they are in the image, how well they
// lie in the tangent plane of the pixel, and how alike the normals are (after Kopf et al., "Joint Bilateral Upsampling",
// 2007). As in denoise_joint.frag, n . P is affine in the place times depth: (line.x + line.y i + line.z j) z for texel i, j.
#needs es300
#include "lib/precision.glsl"
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/output.glsl"
#include "lib/accumulate.glsl"

uniform sampler2D u_packed;   // small: visibility and linear depth
uniform sampler2D u_z;
uniform sampler2D u_normal;
uniform sampler2D u_small_normal;
#ifdef BENT
uniform sampler2D u_lost;
#endif
#ifdef BOUNCE
uniform sampler2D u_gained;
#endif
uniform vec2 u_small_texel;   // 1 / size of the small image
uniform float u_small_scale;  // pixels along each side of one of its texels
uniform float u_per_pixel;    // 1 / (tolerance in pixels * size of a pixel at w = 1)
#ifdef REFINE
uniform float u_least;        // weight below which a pixel is left to be drawn at full size
#endif

// What the four texels have in common: the plane (see above), and of what does not scale with depth.
struct SsaoPlane {
    vec2 normal;  // of the pixel, encoded
    vec2 corner;  // the lower left of the four
    vec3 line;
    vec3 still;
    float here;
};

// Add a texel. nearest is (visibility, distance off the plane) of the one that is least off.
void ssao_tap(inout SsaoSum sum, SsaoPlane plane, vec2 q, LOW float weight, inout vec2 nearest) {
    vec2 place = (plane.corner + q + 0.5) * u_small_texel;
#ifdef AVERAGED
    vec2 tap = SAMPLE(u_packed, place).xz;  // of frames: visibility, how many they are, linear depth
#else
    vec2 tap = ssao_unpack(SAMPLE(u_packed, place).r);
#endif
    vec2 turn = SAMPLE(u_small_normal, place).xy - plane.normal;  // as encoded: about the angle, and cheap
    float off = abs(dot(plane.line, vec3(1.0, q)) * tap.y - plane.here);
#ifndef PINHOLE
    off = abs(dot(plane.line, vec3(1.0, q)) * tap.y + dot(plane.still, vec3(1.0, q)) - plane.here);
#endif
    off = tap.y > 0.0 ? min(off, 1e30) : 2e30;  // background, which has no visibility, never stands in
    nearest = off < nearest.y ? vec2(tap.x, off) : nearest;
    LOW float fits = clamp(2.0 - off, 0.0, 1.0);
    LOW float alike = clamp(1.5 - 4.0 * dot(turn, turn), 0.0, 1.0);
    sum.open += vec2(tap.x, 1.0) * (fits * alike * weight);
#ifdef BENT
    sum.lost += SAMPLE(u_lost, place).xyz * (fits * alike * weight);
#endif
#ifdef BOUNCE
    sum.gained += SAMPLE(u_gained, place) * (fits * alike * weight);
#endif
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    float z = SAMPLE(u_z, uv).r;
    vec2 normal = SAMPLE(u_normal, uv).xy;
    vec3 n = ssao_decode_normal(normal);
    vec2 at = floor(gl_FragCoord.xy) / u_small_scale;  // a texel lies where the first of its pixels lies
    vec2 f = fract(at);
    vec2 step = u_small_scale * u_texel, first = (at - f) * step + 0.5 * u_texel;
    float per_unit = u_per_pixel / max(ssao_w(z), 1e-30);
    SsaoPlane plane;
    plane.normal = normal;
    plane.corner = at - f;
    plane.line = per_unit * vec3(
        dot(n.xy, u_ray * first + u_ray0) - n.z, dot(n.xy, u_ray[0]) * step.x, dot(n.xy, u_ray[1]) * step.y);
    plane.still = vec3(0.0);
    plane.here = per_unit * dot(n, ssao_position(uv, z));
#ifndef PINHOLE
    plane.still = per_unit * vec3(
        dot(n.xy, u_org * first + u_org0), dot(n.xy, u_org[0]) * step.x, dot(n.xy, u_org[1]) * step.y);
#endif
    vec2 nearest = vec2(1.0, 2e30);
    SsaoSum sum = ssao_nothing();
    ssao_tap(sum, plane, vec2(0.0), (1.0 - f.x) * (1.0 - f.y), nearest);
    ssao_tap(sum, plane, vec2(1.0, 0.0), f.x * (1.0 - f.y), nearest);
    ssao_tap(sum, plane, vec2(0.0, 1.0), (1.0 - f.x) * f.y, nearest);
    ssao_tap(sum, plane, vec2(1.0, 1.0), f.x * f.y, nearest);
    // Where next to nothing fits, the texel that is least off stands in.
    float visibility = sum.open.y > 0.02 ? sum.open.x / sum.open.y : nearest.x;
    frag_color = vec4(z > 0.0 ? visibility : 1.0);
#ifdef BENT
    ssao_write_bent(sum.lost / max(sum.open.y, 0.02), n);
#endif
#ifdef BOUNCE
    ssao_write_gained(sum.gained / max(sum.open.y, 0.02));
#endif
#ifdef REFINE
    gl_FragDepth = z > 0.0 && sum.open.y < u_least ? 0.0 : 1.0;
#endif
}
