// The mean of what occluders count at all distances within the radius.
#if FALLOFF == 3
const float SSAO_MEAN_RHO = 0.58302;
#else
const float SSAO_MEAN_RHO = 1.0 / 3.0;
#endif

// How much an occluder counts at x = distance / radius < 1: the shapes of ssao_gl/falloff.py, by the number FALLOFF.
float ssao_rho(float x) {
#if FALLOFF == 1    // quadratic
    return (1.0 - x) * (1.0 - x);
#elif FALLOFF == 2  // obscurance
    return 1.0 - sqrt(x);
#else               // alchemy, u = pi / (8 ln(1 + sqrt 2))
    float u = 0.44555105, m = max(x, u);
    return u * x / (m * m);
#endif
}
