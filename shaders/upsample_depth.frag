// Visibility of a smaller image at full size by depth alone: the four nearest of its texels, by how near they are in the image
// and how near their depth is to the pixel's, in radii.
#needs es300
#include "lib/view.glsl"
#include "lib/output.glsl"

uniform sampler2D u_packed;   // small: visibility and linear depth
uniform sampler2D u_z;
uniform float u_small_scale;  // pixels along each side of one of its texels
uniform float u_per_depth;    // 1 / the difference of depth up to which a texel counts in full

// (visibility, 1) of a texel by its weight.
vec2 ssao_tap(ivec2 texel, float weight, float z, inout vec2 nearest) {
    vec2 tap = ssao_unpack(texelFetch(u_packed, min(texel, textureSize(u_packed, 0) - 1), 0).r);
    float off = tap.y > 0.0 ? abs(tap.y - z) * u_per_depth : 1e30;
    nearest = off < nearest.y ? vec2(tap.x, off) : nearest;
    return vec2(tap.x, 1.0) * (weight * clamp(2.0 - off, 0.0, 1.0));
}

void main() {
    vec2 at = floor(gl_FragCoord.xy) / u_small_scale;
    ivec2 corner = ivec2(at);
    vec2 f = fract(at);
    float z = texelFetch(u_z, ivec2(gl_FragCoord.xy), 0).r;
    vec2 nearest = vec2(1.0, 1e29);
    vec2 sum = ssao_tap(corner, (1.0 - f.x) * (1.0 - f.y), z, nearest);
    sum += ssao_tap(corner + ivec2(1, 0), f.x * (1.0 - f.y), z, nearest);
    sum += ssao_tap(corner + ivec2(0, 1), (1.0 - f.x) * f.y, z, nearest);
    sum += ssao_tap(corner + 1, f.x * f.y, z, nearest);
    float visibility = sum.y > 0.02 ? sum.x / sum.y : nearest.x;
    frag_color = vec4(z > 0.0 ? visibility : 1.0);
}
