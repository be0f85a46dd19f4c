// Texels of residuals: sum over rays of what they see more than the screen, number of rays, linear depth (0: no surface), normal.
// The normal is as encoded by lib/normal.glsl, within -2..2, in 12 bits each: a whole number that 32-bit floats hold.
float ssao_pack_normal(vec2 e) {
    vec2 steps = floor(clamp(e * 1023.0 + 2047.5, 0.0, 4095.0));
    return steps.x * 4096.0 + steps.y;
}

vec2 ssao_unpack_normal(float number) {
    float high = floor(number / 4096.0);
    return (vec2(high, number - high * 4096.0) - 2047.0) / 1023.0;
}

// How alike two encoded normals are, in 0..1: about by their angle, and cheap.
float ssao_alike(vec2 a, vec2 b) {
    vec2 turn = a - b;
    return clamp(1.5 - 4.0 * dot(turn, turn), 0.0, 1.0);
}
