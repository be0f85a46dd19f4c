// One triangle that covers the target. Fragment shaders take their place from gl_FragCoord, which every driver
// gives exactly, not from an interpolated varying, which they round differently.
ATTRIBUTE vec2 a_corner;

void main() { gl_Position = vec4(a_corner, 0.0, 1.0); }
