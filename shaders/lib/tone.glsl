// Khronos PBR Neutral (2024): base colours stay as they are up to .8, what is brighter is pressed below white and loses its hue.
vec3 ssao_tone(vec3 color) {
    float least = min(color.r, min(color.g, color.b));
    color -= least < 0.08 ? least - 6.25 * least * least : 0.04;
    float peak = max(color.r, max(color.g, color.b)), start = 0.76, room = 1.0 - start;
    if (peak < start) return color;
    float pressed = 1.0 - room * room / (peak + room - start);
    return mix(vec3(pressed), color * (pressed / peak), 1.0 / (0.15 * (peak - pressed) + 1.0));
}
