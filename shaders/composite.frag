// The picture: colour times light, where occlusion dims the ambient part of the light.
#include "lib/color.glsl"
uniform vec2 u_texel;
uniform sampler2D u_color;       // sRGB; with DIRECT its alpha is the direct light, 1 on background
uniform sampler2D u_visibility;
uniform LOW float u_ambient;     // share of the light that is ambient
#ifdef TONED
uniform float u_power;           // contrast of visibility
uniform LOW vec3 u_tint;         // linear light that is left where all is hidden
#endif

void main() {
    vec2 uv = gl_FragCoord.xy * u_texel;
    LOW vec4 color = SAMPLE(u_color, uv);
    LOW float visibility = SAMPLE(u_visibility, uv).r;
#ifdef TONED
    LOW vec3 open = mix(u_tint, vec3(1.0), pow(max(visibility, 1e-4), u_power));
#ifdef DIRECT
    LOW vec3 tinted = u_ambient * open + (1.0 - u_ambient) * color.a;
    color.a = 1.0;
#else
    LOW vec3 tinted = mix(vec3(1.0), open, u_ambient);
#endif
    for (int i = 0; i < 3; i++) color[i] = ssao_times_linear(color.rgb, tinted[i])[i];
    frag_color = color;
#elif defined(DIRECT)
    LOW float light = u_ambient * visibility + (1.0 - u_ambient) * color.a;
    frag_color = vec4(ssao_times_linear(color.rgb, light), 1.0);
#else
    LOW float light = mix(1.0, visibility, u_ambient);
    frag_color = vec4(ssao_times_linear(color.rgb, light), color.a);
#endif
}
