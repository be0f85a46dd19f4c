// The fragment shader of the lecture (UPC; after Sunet 2016, "Ambient Occlusion on Mobile"), kept to the letter:
// its formulas, its uniforms, its window of 5 % of the far distance. See methods/lecture.py for what it gets wrong.
#include "lib/normal.glsl"
#include "lib/output.glsl"

uniform sampler2D depth;      // z / far, 1 on background
uniform sampler2D normal;     // view space, encoded
uniform sampler2D rotation;   // unit vectors
uniform mat4 iProjection;     // clip -> view
uniform vec2 samples[NSAMPLES];
uniform vec2 radius;          // share of the image at depth 0; both the same unless a part of an image is drawn
uniform vec2 ssaoSize;        // pixels
uniform float rotationWidth;  // pixels
uniform vec2 texelSize;       // 1 / ssaoSize
uniform float u_far;          // only to hand linear depth on to the blur

// The far-plane point times linear depth.
vec3 unproject(vec2 uv, float d) {
    vec4 p = iProjection * vec4(uv * 2.0 - 1.0, 1.0, 1.0);
    return p.xyz / p.w * d;
}

void main() {
    vec2 uv = gl_FragCoord.xy * texelSize;
    float d_p = SAMPLE(depth, uv).r;
    vec3 p = unproject(uv, d_p);
    vec3 n_p = ssao_decode_normal(SAMPLE(normal, uv).xy);
    vec2 turn = SAMPLE(rotation, uv * ssaoSize / rotationWidth).xy;
    vec2 pradius = radius * (1.0 - d_p);
    float ao = 0.0;
    for (int i = 0; i < NSAMPLES; i++) {
        vec2 uv_q = uv + pradius * reflect(samples[i], turn);
        float d_q = SAMPLE(depth, uv_q).r;
        vec3 v = unproject(uv_q, d_q) - p;
        vec3 n_q = ssao_decode_normal(SAMPLE(normal, uv_q).xy);
        // Guard: the lecture normalises v, which is undefined when the tap is the pixel itself; such a tap counts 0.
        float length2 = dot(v, v);
        v = length2 > 0.0 ? v * inversesqrt(length2) : vec3(0.0);
        float a = smoothstep(0.0, 1.0, dot(v, n_p));
        float b = 1.0 - dot(n_p, n_q);
        float c = step(abs(d_q - d_p), 0.05);
        ao += a * b * c;
    }
    // Guard: ao may exceed NSAMPLES (b reaches 2), and background has no normal: ssao_write clamps, and writes 1 there.
    ssao_write(1.0 - ao / float(NSAMPLES), d_p < 1.0 ? d_p * u_far : 0.0);
}
