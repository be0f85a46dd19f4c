// One bounce from what is seen around a pixel: Ritschel, Grosch & Seidel, "Approximating Dynamic Global Illumination in Image Space",
// I3D 2009. Irradiance over pi; lengths in units of the reach.
#needs es300
#include "lib/view.glsl"
#include "lib/normal.glsl"
#include "lib/center_pixel.glsl"
#include "lib/taps.glsl"

uniform sampler2D u_z;
uniform sampler2D u_normals;
uniform sampler2D u_bounce;     // see bounce.frag
uniform vec2 u_bounce_texel;    // 1 / (pixels of the image that it covers)
uniform vec4 u_taps[TAPS];      // unit vectors about +z, distance in 0..1
uniform sampler2D u_turns;
uniform float u_own;            // share of a tap that is this pixel's, where a filter averages those of a tile

// Axes about n: Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
mat3 ssao_axes(vec3 n) {
    float s = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (s + n.z), b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

void main() {
    SsaoPixel pixel = ssao_pixel();
    vec2 here = pixel.at * u_texel;
    vec3 p = ssao_position(here, max(pixel.z, 1e-30));
    vec3 noise = SAMPLE(u_turns, gl_FragCoord.xy / u_noise_width).xyz;
    float reach = max(ssao_reach(-p.z), 1e-30);
    mat3 axes = ssao_axes(pixel.n);
    vec3 sum = vec3(0.0), dimmed = vec3(0.0);
    float blocked = 0.0;
    for (int i = 0; i < TAPS; i++) {
        vec3 way = axes * vec3(reflect(u_taps[i].xy, noise.xy), u_taps[i].z);
        vec3 q = p + way * (fract(u_taps[i].w + noise.z) * reach);
        vec2 uv = ssao_middle(ssao_project(q, here));
        float z = SAMPLE(u_z, uv).r;
        vec3 away = ssao_offset(uv, z, p, reach);
        float distance2 = dot(away, away);
        // Seen before the point, within reach: the point is blocked, and what blocks it sends.
        if (!ssao_inside(uv) || z <= 0.0 || z >= -q.z || distance2 >= 1.0) continue;
        vec3 n = ssao_decode_normal(SAMPLE(u_normals, uv).xy);
        vec4 light = SAMPLE(u_bounce, uv * u_size * u_bounce_texel);
        // A disk of the area that the tap stands for: it cannot send more than all, however near it is.
        float facing = max(dot(pixel.n, away), 0.0) * max(-dot(n, away), 0.0) / max(distance2, 1e-12);
        vec3 sent = light.rgb * (facing / (float(TAPS) * distance2 + u_own));
        sum += sent;
        dimmed += sent * light.a;
        blocked += 1.0 / float(TAPS);
    }
    sum -= blocked * dimmed;  // what sees as little of the environment as the pixel
    frag_color = vec4(pixel.z > 0.0 ? min(sum, 6e4) : vec3(0.0), 1.0);
}
