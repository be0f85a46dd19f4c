#version 330 core
#define ATTRIBUTE in
#define VARYING out
