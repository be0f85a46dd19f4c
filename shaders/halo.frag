// Halos: the picture, painted over where depth lies behind its own blurred image. Unsharp masking of the depth buffer, after Luft,
// Colditz, Deussen, "Image Enhancement by Unsharp Masking the Depth Buffer", SIGGRAPH 2006.
#needs es300
#include "lib/view.glsl"
#include "lib/inverse_depth.glsl"

uniform sampler2D u_image;   // sRGB and alpha
uniform sampler2D u_z;
uniform sampler2D u_means;   // of nearness and of what is covered, around every SCALE-th pixel
uniform float u_radius;      // scene units
uniform vec4 u_color;        // sRGB, and strength

const float STEP = 4.0;      // radii that the mean lies in front by where a halo has half of its strength
const float FAR = 1e3;       // radii that background lies behind all, in a parallel projection

// Between texels interpolated and beyond the last ones extrapolated, so that planes stay planes.
vec2 ssao_means() {
    ivec2 last = textureSize(u_means, 0) - 1;
    vec2 at = floor(gl_FragCoord.xy) / float(SCALE);
    ivec2 corner = max(min(ivec2(at), last - 1), 0), next = min(corner + 1, last);
    vec2 f = at - vec2(corner);
    vec2 low = mix(texelFetch(u_means, corner, 0).xy, texelFetch(u_means, ivec2(next.x, corner.y), 0).xy, f.x);
    return mix(low, mix(texelFetch(u_means, ivec2(corner.x, next.y), 0).xy, texelFetch(u_means, next, 0).xy, f.x), f.y);
}

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel, means = ssao_means();
    vec4 image = SAMPLE(u_image, uv);
    float z = SAMPLE(u_z, uv).r;
    // By how many radii the mean lies in front. Background counts as what it is, far behind all.
    float before = u_w.x > 0.0 ? z * (means.x * z - 1.0) / u_radius : (means.x + z * means.y) / u_radius - FAR * (1.0 - means.y);
    float radii = clamp(before, 0.0, 1e6);
    float halo = u_color.a * (z > 0.0 ? radii / (STEP + radii) : clamp(2.0 * means.y, 0.0, 1.0));
    float alpha = mix(image.a, 1.0, halo);
    frag_color = vec4(mix(image.rgb * image.a, u_color.rgb, halo) / max(alpha, 1e-6), alpha);
}
