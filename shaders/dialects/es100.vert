#version 100
precision highp float;
#define ATTRIBUTE attribute
#define VARYING varying
