#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
#define SAMPLE texture
#define VARYING in
#ifndef TARGETS
layout(location = 0) out vec4 frag_color;
#endif
