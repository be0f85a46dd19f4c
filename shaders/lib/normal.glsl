// Unit normals in two half floats by Lambert's equal-area azimuthal map about the view axis: no singularity but
// straight away from the viewer, and a decoder without a normalisation.
vec2 ssao_encode_normal(vec3 n) { return n.xy * sqrt(2.0 / max(1.0 + n.z, 1e-4)); }

vec3 ssao_decode_normal(vec2 e) {
    float f = min(dot(e, e), 4.0);
    return vec3(e * sqrt(1.0 - 0.25 * f), 1.0 - 0.5 * f);
}
