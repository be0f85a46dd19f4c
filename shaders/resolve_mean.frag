// The mean over the samples of a pixel. With SRGB in linear light; with ALPHA of what covers the pixel, each sample by its alpha,
// which becomes the share that is covered: straight alpha, right over any background.
#needs es300
#include "lib/srgb.glsl"
uniform sampler2D u_samples;

void ssao_add(inout vec4 sum, float i) {
    ivec2 at = ivec2(gl_FragCoord.xy) * SIDE + ivec2(mod(i, float(SIDE)), floor(i / float(SIDE)));
    vec4 one = texelFetch(u_samples, at, 0);
#ifdef SRGB
    one.rgb = ssao_srgb_to_linear(one.rgb);
#endif
#ifdef ALPHA
    one.rgb *= one.a;
#endif
    sum += one;
}

void main() {
    vec4 sum = vec4(0.0);
#repeat SAMPLES ssao_add(sum, float(@));
    vec4 mean = sum / float(SAMPLES);
#ifdef ALPHA
    mean.rgb = mean.a > 0.0 ? mean.rgb / mean.a : vec3(0.0);
#endif
#ifdef SRGB
    mean.rgb = ssao_linear_to_srgb(mean.rgb);
#endif
    frag_color = mean;
}
