// The sample of a pixel whose depth is the median, background farthest: of two surfaces the one that covers more of the pixel,
// the nearer where they share it. A mean would lie on neither.
#needs es300
uniform sampler2D u_z;
#ifdef Z
layout(location = Z) out vec4 out_z;
#endif
#ifdef NORMAL
uniform sampler2D u_normal;
layout(location = NORMAL) out vec4 out_normal;
#endif
#ifdef BENT
uniform sampler2D u_bent;
layout(location = BENT) out vec4 out_bent;
#endif
#ifdef LABEL
uniform highp usampler2D u_label;
layout(location = LABEL) out uvec4 out_label;
#endif

ivec2 ssao_at(float i) {
    return ivec2(gl_FragCoord.xy) * SIDE + ivec2(mod(i, float(SIDE)), floor(i / float(SIDE)));
}

// Linear depth of a sample; of background beyond all.
float ssao_depth(float i) {
    float z = texelFetch(u_z, ssao_at(i), 0).r;
    return z > 0.0 ? z : 3.4e38;
}

// Sample i is the median when as many are nearer as half of them; the first of equals comes first.
void ssao_rank(inout float median, float i) {
    float z = ssao_depth(i), nearer = 0.0;
#repeat SAMPLES { float other = ssao_depth(float(@)); nearer += other < z || (other == z && float(@) < i) ? 1.0 : 0.0; }
    median = nearer == floor(0.5 * float(SAMPLES - 1)) ? i : median;
}

void main() {
    float median = 0.0;
#repeat SAMPLES ssao_rank(median, float(@));
    ivec2 at = ssao_at(median);
#ifdef Z
    out_z = texelFetch(u_z, at, 0);
#endif
#ifdef NORMAL
    out_normal = texelFetch(u_normal, at, 0);
#endif
#ifdef BENT
    out_bent = texelFetch(u_bent, at, 0);
#endif
#ifdef LABEL
    out_label = texelFetch(u_label, at, 0);
#endif
}
