// A caller's view-space normals (x, y, z in -1..1, any length) to the encoding that the passes read.
#include "lib/normal.glsl"
uniform vec2 u_texel;
uniform sampler2D u_normal_xyz;

void main() {
    vec3 n = SAMPLE(u_normal_xyz, gl_FragCoord.xy * u_texel).xyz;
    float length2 = dot(n, n);
    bool usable = length2 > 1e-12 && length2 < 1e12;  // false for NaN too
    n = usable ? n * inversesqrt(length2) : vec3(0.0, 0.0, 1.0);
    frag_color = vec4(ssao_encode_normal(n), 0.0, 0.0);
}
