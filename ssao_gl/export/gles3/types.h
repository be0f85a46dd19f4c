/* Written by ssao-gl export: the pipeline as plain data. ssao.c interprets it. */
#include "ssao.h"

enum { SSAO_NUMBER, SSAO_SETTING, SSAO_VIEW }; /* kinds of SsaoPart */

/* Numbers of a uniform: factor; or times the setting or view value `what`; times the setting `by`, unless that is -1.
   inverse: one over that. axis 0 or 1: only that component of a pair, and 0 in the other. resource: whose size. */
typedef struct { int kind, what; double factor; int by, inverse, axis, resource; } SsaoPart;
typedef struct { const char *name; int first, count; } SsaoUniform;     /* of SSAO_PARTS */
typedef struct { const char *uniform; int index; } SsaoSampler;         /* resource, or table */
typedef struct { GLenum format; int scale; } SsaoSlot;                  /* a texel for scale x scale pixels */
typedef struct { int width, height, channels; const float *data; } SsaoTable;
typedef struct { const char *name; double value, above, low, high; } SsaoSetting;
typedef struct { int first, count; } SsaoRange;
typedef struct {
    const char *name, *shader;
    int scale, write_count, writes[4];          /* resources */
    int clears[4]; float clear[4][4];           /* what targets are filled with before */
    int depth_slot, depth_writes; GLenum depth_passes; /* slot -1: none */
    int least[2];                               /* runs where width or height is at least that; 0: never for its sake */
    SsaoRange samplers, tables, uniforms;       /* of SSAO_SAMPLERS, SSAO_SAMPLERS, SSAO_UNIFORMS */
} SsaoStep;

/* Resources that the caller gives; the others follow. */
enum { SSAO_DEPTH, SSAO_NORMALS, SSAO_COLOR, SSAO_INPUTS };
