#version 100
precision highp float;
precision highp int;
precision highp sampler2D;
#define ES100
#define SAMPLE texture2D
#define VARYING varying
#define frag_color gl_FragColor
