#version 330 core
#define SAMPLE texture
#define VARYING in
#ifndef TARGETS
layout(location = 0) out vec4 frag_color;
#endif
