#version 300 es
precision highp float;
#define ATTRIBUTE in
#define VARYING out
