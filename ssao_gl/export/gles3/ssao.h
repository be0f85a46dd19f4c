/* Ambient occlusion on OpenGL ES 3: runs the pipeline in pipeline.h. Needs a current context, and no other library.
   Calls leave behind: the program, textures and samplers of the first 8 units, the vertex array, buffers, the framebuffer and the
   viewport; they expect blending, culling, scissor, stencil and depth test to be off, and colours to be written. */
#ifndef SSAO_H
#define SSAO_H

#include <GLES3/gl3.h>

typedef struct Ssao Ssao;

typedef struct {
    GLuint depth;   /* window depth (a depth texture, or its values in red) or eye depth, as the pipeline was exported */
    GLuint normals; /* view space, xyz in -1..1; 0 where the pipeline takes none */
    GLuint color;   /* sRGB values, RGBA8; 0 where the pipeline takes none */
    double projection[16]; /* column by column; clip depth from -1 to 1 */
} SsaoInputs;

/* folder: of the shaders. Returns NULL, with the reason in ssao_error(). */
Ssao *ssao_new(const char *folder);
/* Pixels of your textures. Returns 0 where they cannot be, with the reason in ssao_error(). */
int ssao_resize(Ssao *ssao, int width, int height);
/* Change a setting, such as "radius" or "tint.r" (linear light). Returns 0 for one that cannot change, or a value out of range. */
int ssao_set(Ssao *ssao, const char *name, double value);
/* Draw. Returns the result's texture, valid until the next call: visibility in red, or the picture. 0: see ssao_error(). */
GLuint ssao_apply(Ssao *ssao, const SsaoInputs *inputs);
void ssao_free(Ssao *ssao);
/* Why the last call failed, in one line. */
const char *ssao_error(void);

#endif
