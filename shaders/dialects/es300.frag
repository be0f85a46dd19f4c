#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
#define SAMPLE texture
#define VARYING in
#ifndef TARGETS
layout(location = 0) out vec4 frag_color;
#endif
#ifdef FINITE  // ssao-gl stress: what is NaN or infinite stays so, and does not hide behind a clamp
uniform float u_zero;  // never set, and so 0
#define min(a, b) (min(a, b) + u_zero * ((a) + (b)))
#define max(a, b) (max(a, b) + u_zero * ((a) + (b)))
#define clamp(x, a, b) (clamp(x, a, b) + u_zero * (x))
#endif
