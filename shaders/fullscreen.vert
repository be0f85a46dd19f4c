// One triangle that covers the target. Fragment shaders take their place from gl_FragCoord, which every driver
// gives exactly, not from an interpolated varying, which they round differently.
ATTRIBUTE vec2 a_corner;

uniform float u_test_depth;  // 0: half way, 1: on the far plane, for passes that are tested against a depth buffer

void main() { gl_Position = vec4(a_corner, u_test_depth, 1.0); }
