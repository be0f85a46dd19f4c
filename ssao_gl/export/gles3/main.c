/* Ambient occlusion of a depth image on headless EGL.
   cc -O2 main.c ssao.c -lEGL -lGLESv2 -lm -o ssao && ./ssao depth.pfm out.pgm --yfov-deg 50 0.1 100 radius=0.5 */
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssao.h"

static const char USAGE[] =
    "usage: ssao DEPTH.pfm OUT.pgm|OUT.ppm [--yfov-deg ANGLE NEAR FAR | --projection M0 .. M15]\n"
    "            [--normals N.pfm] [--color C.ppm] [--shaders FOLDER] [NAME=VALUE ..]\n"
    "depth: window depth 0..1, or distance along the view axis, as exported. --projection: column by column, clip depth -1..1;\n"
    "FAR may be inf. NAME=VALUE: a setting, such as radius=0.5.\n";

static int stop(const char *what, const char *why) {
    fprintf(stderr, "ssao: %s: %s\n", what, why);
    return 2;
}

/* A context of OpenGL ES 3 without a window. Returns why there is none, or NULL. */
static const char *open_context(void) {
    static const EGLint config_of[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    static const EGLint version[] = {EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE};
    PFNEGLGETPLATFORMDISPLAYEXTPROC platform = (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLDisplay displays[2] = {platform ? platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL) : EGL_NO_DISPLAY, eglGetDisplay(EGL_DEFAULT_DISPLAY)};
    for (int i = 0; i < 2; i++) {
        EGLConfig config;
        EGLint found = 0;
        if (displays[i] == EGL_NO_DISPLAY || !eglInitialize(displays[i], NULL, NULL)) continue;
        if (!eglBindAPI(EGL_OPENGL_ES_API) || !eglChooseConfig(displays[i], config_of, &config, 1, &found) || !found) continue;
        EGLContext context = eglCreateContext(displays[i], config, EGL_NO_CONTEXT, version);
        if (context != EGL_NO_CONTEXT && eglMakeCurrent(displays[i], EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return NULL;
    }
    return "no EGL display gives a context of OpenGL ES 3 without a surface";
}

/* Pixels of a PFM (rows from the bottom, as OpenGL has them) or PPM (from the top; turned here); NULL where it is no such file. */
static void *read_image(const char *path, const char *magic, int *w, int *h, size_t texel) {
    FILE *file = fopen(path, "rb");
    char kind[3] = "";
    double last = 0;
    unsigned char *data = NULL;
    int floats = magic[1] == 'f' || magic[1] == 'F';
    if (file && fscanf(file, "%2s %d %d %lf", kind, w, h, &last) == 4 && !strcmp(kind, magic) && *w > 0 && *h > 0 && *w <= 65536 &&
        *h <= 65536 && (floats ? last < 0 : last == 255) && fgetc(file) != EOF) {
        size_t row = (size_t)*w * texel;
        data = malloc(row * (size_t)*h);
        for (int y = 0; data && y < *h; y++)
            if (fread(data + row * (size_t)(floats ? y : *h - 1 - y), 1, row, file) != row) { free(data); data = NULL; }
    }
    if (file) fclose(file);
    return data;
}

static GLuint upload(const void *data, GLenum internal, GLenum layout, GLenum type, int w, int h) {
    GLuint made;
    glGenTextures(1, &made);
    glBindTexture(GL_TEXTURE_2D, made);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, w, h, 0, layout, type, data);
    return made;
}

/* Write red as PGM, or three channels as PPM, rows from the top. */
static int write_image(const char *path, const unsigned char *rgba, int w, int h) {
    size_t length = strlen(path);
    int channels = length > 4 && !strcmp(path + length - 4, ".ppm") ? 3 : 1, fine = 1;
    FILE *file = fopen(path, "wb");
    if (!file) return 0;
    fprintf(file, "P%d\n%d %d\n255\n", channels == 3 ? 6 : 5, w, h);
    for (int y = h - 1; y >= 0; y--)
        for (int x = 0; x < w; x++) fine &= fwrite(rgba + 4 * ((size_t)y * (size_t)w + (size_t)x), 1, (size_t)channels, file) == (size_t)channels;
    return !fclose(file) && fine;
}

static void perspective(double *m, double yfov, double n, double f, double aspect) {
    double s = 1 / tan(yfov * acos(-1.0) / 360);
    memset(m, 0, 16 * sizeof *m);
    m[0] = s / aspect;
    m[5] = s;
    m[10] = isinf(f) ? -1 : (f + n) / (n - f);
    m[14] = isinf(f) ? -2 * n : 2 * f * n / (n - f);
    m[11] = -1;
}

int main(int count, char **words) {
    const char *normals_path = NULL, *color_path = NULL, *folder = "shaders", *why;
    double lens[3] = {50, 0.1, INFINITY};
    int w, h, w2, h2, projected = 0;
    SsaoInputs inputs = {0};
    if (count < 3) { fputs(USAGE, stderr); return 2; }
    float *depth = read_image(words[1], "Pf", &w, &h, sizeof(float));
    if (!depth) return stop(words[1], "expected a PFM file of one channel, little-endian (Pf, width, height, -1)");
    if ((why = open_context())) return stop("EGL", why);
    Ssao *ssao = NULL;
    for (int pass = 0; pass < 2; pass++) { /* options, and then settings, which need what options say */
        for (int i = 3; i < count; i++) {
            int left = count - 1 - i;
            char *equals = strchr(words[i], '=');
            if (!strcmp(words[i], "--projection") && left >= 16) {
                for (int k = 0; k < 16; k++) inputs.projection[k] = strtod(words[++i], NULL);
                projected = 1;
            } else if (!strcmp(words[i], "--yfov-deg") && left >= 3) {
                for (int k = 0; k < 3; k++) lens[k] = strtod(words[++i], NULL);
            } else if (!strcmp(words[i], "--normals") && left) normals_path = words[++i];
            else if (!strcmp(words[i], "--color") && left) color_path = words[++i];
            else if (!strcmp(words[i], "--shaders") && left) folder = words[++i];
            else if (!equals || words[i][0] == '-') return stop(words[i], "unknown option, or too few values; without arguments the options are listed");
            else if (pass) {
                *equals = 0;
                if (!ssao_set(ssao, words[i], strtod(equals + 1, NULL))) return stop("setting", ssao_error());
            }
        }
        if (!pass && !(ssao = ssao_new(folder))) return stop("ssao", ssao_error());
    }
    if (!projected) perspective(inputs.projection, lens[0], lens[1], lens[2], (double)w / h);
    inputs.depth = upload(depth, GL_R32F, GL_RED, GL_FLOAT, w, h);
    if (normals_path) {
        float *normals = read_image(normals_path, "PF", &w2, &h2, 3 * sizeof(float));
        if (!normals || w2 != w || h2 != h) return stop(normals_path, "expected a PFM file of three channels and of the depth's size");
        inputs.normals = upload(normals, GL_RGB32F, GL_RGB, GL_FLOAT, w, h);
        free(normals);
    }
    if (color_path) {
        unsigned char *color = read_image(color_path, "P6", &w2, &h2, 3);
        if (!color || w2 != w || h2 != h) return stop(color_path, "expected a PPM file (P6, 255) of the depth's size");
        inputs.color = upload(color, GL_RGB8, GL_RGB, GL_UNSIGNED_BYTE, w, h);
        free(color);
    }
    GLuint result = ssao_resize(ssao, w, h) ? ssao_apply(ssao, &inputs) : 0, framebuffer;
    if (!result) return stop("ssao", ssao_error());
    unsigned char *rgba = malloc(4 * (size_t)w * (size_t)h);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, result, 0);
    if (rgba) glReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    if (!rgba || glGetError() != GL_NO_ERROR) return stop("OpenGL", "the frame could not be drawn or read");
    if (!write_image(words[2], rgba, w, h)) return stop(words[2], "cannot be written");
    ssao_free(ssao);
    free(rgba);
    free(depth);
    return 0;
}
