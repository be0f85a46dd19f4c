/* Values of a view in double precision, as the schema defines them. For ssao.c, behind pipeline.h. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

typedef struct { int count; double v[16]; } Numbers;

/* Inverse of a matrix (column by column) by Gauss and Jordan, with the largest pivot of each column. */
static int inverse(const double *m, double *out) {
    double a[4][8];
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 8; c++) a[r][c] = c < 4 ? m[4 * c + r] : c - 4 == r;
    for (int c = 0; c < 4; c++) {
        int p = c;
        for (int r = c + 1; r < 4; r++) if (fabs(a[r][c]) > fabs(a[p][c])) p = r;
        if (!(fabs(a[p][c]) > 0)) return 0;
        for (int i = 0; i < 8; i++) { double t = a[c][i]; a[c][i] = a[p][i]; a[p][i] = t; }
        double pivot = a[c][c];
        for (int i = 0; i < 8; i++) a[c][i] /= pivot;
        for (int r = 0; r < 4; r++) {
            double f = a[r][c];
            for (int i = 0; i < 8 && r != c; i++) a[r][i] -= f * a[c][i];
        }
    }
    for (int r = 0; r < 4; r++) for (int c = 0; c < 4; c++) out[4 * c + r] = a[r][4 + c];
    return 1;
}

static Numbers numbers(int count, ...) {
    Numbers made = {count, {0}};
    va_list more;
    va_start(more, count);
    for (int i = 0; i < count; i++) made.v[i] = va_arg(more, double);
    va_end(more);
    return made;
}

/* A row of the inverse projection for (u, v, window depth - far, 1). */
static Numbers depth_row(const double *un, int r, int far_end, double scale) {
    double a = un[r], b = un[4 + r], c = un[8 + r], d = un[12 + r];
    return numbers(4, 2 * a / scale, 2 * b / scale, 2 * c / scale, (d - a - b + c * (2 * far_end - 1)) / scale);
}

/* What depends on the projection and the size (pixels) alone, by SSAO_VIEW_ names. Returns NULL, or why there is no such view.
   pinhole: whether all rays meet in the eye. */
static const char *look(const double *m, const int *size, Numbers *view, int *pinhole) {
    double un[16], w = size[0], h = size[1], det = m[0] * m[5] - m[4] * m[1], planes[2], tiny = 0;
    for (int i = 0; i < 16; i++) if (!isfinite(m[i])) return "projection: expected 16 finite numbers";
    if (det == 0 || m[3] != 0 || m[7] != 0) return "the projection flattens the image, or its clip w depends on x or y";
    if (m[11] > 0) return "the projection looks along +z; view space looks along -z";
    if (!inverse(m, un)) return "the projection cannot be inverted";
    for (int c = 0; c < 4; c++) tiny = fmax(tiny, 1e-13 * fabs(un[4 * c + 3]));
    for (int end = 0; end < 2; end++) {
        double ndc = 2 * end - 1, pw = un[11] * ndc + un[15];
        planes[end] = fabs(pw) > tiny ? -(un[10] * ndc + un[14]) / pw : INFINITY;
    }
    int far_end = planes[1] > planes[0];
    double a = m[5] / det, b = -m[1] / det, c = -m[4] / det, d = m[0] / det, w1 = -m[11], w0 = m[15], scale = 0;
    Numbers den = depth_row(un, 3, far_end, 1);
    for (int i = 0; i < 4; i++) scale = fmax(scale, fabs(den.v[i]));
    scale = scale > 0 ? scale : 1;
    *pinhole = w0 == 0 && m[12] == 0 && m[13] == 0;
    if (SSAO_NEEDS_PERSPECTIVE && !*pinhole) return "this method is for perspective cameras only";
    if (SSAO_NEEDS_FAR_PLANE && isinf(planes[far_end])) return "this method needs a far plane";
    view[SSAO_VIEW_FAR] = numbers(1, planes[far_end]);
    view[SSAO_VIEW_PIXEL] = numbers(1, fmax(2 * hypot(a, b) / w, 2 * hypot(c, d) / h));
    memcpy(view[SSAO_VIEW_INVERSE_PROJECTION].v, un, sizeof un);
    view[SSAO_VIEW_INVERSE_PROJECTION].count = 16;
    view[SSAO_VIEW_IMAGE_SIZE] = numbers(2, w, h);
    view[SSAO_VIEW_IMAGE_TEXEL] = numbers(2, 1 / w, 1 / h);
    view[SSAO_VIEW_IMAGE_SHARE] = numbers(2, 1.0, 1.0);
    view[SSAO_VIEW_WINDOW_DEPTH_FAR] = numbers(1, (double)far_end);
    view[SSAO_VIEW_WINDOW_DEPTH_NUM] = depth_row(un, 2, far_end, -scale);
    view[SSAO_VIEW_WINDOW_DEPTH_DEN] = depth_row(un, 3, far_end, scale);
    view[SSAO_VIEW_RAY] = numbers(4, 2 * w1 * a, 2 * w1 * b, 2 * w1 * c, 2 * w1 * d);
    view[SSAO_VIEW_RAY0] = numbers(2, a * (m[8] - w1) + c * (m[9] - w1), b * (m[8] - w1) + d * (m[9] - w1));
    view[SSAO_VIEW_ORG] = numbers(4, 2 * w0 * a, 2 * w0 * b, 2 * w0 * c, 2 * w0 * d);
    view[SSAO_VIEW_ORG0] = numbers(2, -(a * (m[12] + w0) + c * (m[13] + w0)), -(b * (m[12] + w0) + d * (m[13] + w0)));
    view[SSAO_VIEW_CLIP_W] = numbers(2, w1, w0);
    view[SSAO_VIEW_UV_PER_UNIT] = numbers(4, m[0] / 2, m[1] / 2, m[4] / 2, m[5] / 2);
    return NULL;
}
