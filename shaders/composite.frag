// The picture: colour times light, where occlusion dims the ambient part of the light.
#include "lib/color.glsl"
uniform vec2 u_texel;
uniform sampler2D u_color;       // sRGB; with DIRECT its alpha is the direct light, 1 on background
uniform sampler2D u_visibility;
uniform LOW float u_ambient;     // share of the light that is ambient

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    LOW vec4 color = SAMPLE(u_color, uv);
    LOW float visibility = SAMPLE(u_visibility, uv).r;
#ifdef DIRECT
    LOW float light = u_ambient * visibility + (1.0 - u_ambient) * color.a;
    frag_color = vec4(ssao_times_linear(color.rgb, light), 1.0);
#else
    LOW float light = mix(1.0, visibility, u_ambient);
    frag_color = vec4(ssao_times_linear(color.rgb, light), color.a);
#endif
}
