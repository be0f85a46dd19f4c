/* See ssao.h. The data is in pipeline.h, what it means in pipeline.schema.json. */
#include "ssao.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline.h"
#include "view.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))
#define STEPS COUNT(SSAO_STEPS)
#define SLOTS COUNT(SSAO_SLOTS)
#define RESOURCES COUNT(SSAO_RESOURCE_SLOTS)

struct Ssao {
    char *folder;
    int size[2];
    GLuint programs[STEPS][2]; /* by step, and whether all rays meet in the eye */
    GLuint tables[COUNT(SSAO_TABLES)], slots[SLOTS], framebuffers[STEPS];
    GLuint clamp, repeat, vao, corners;
    int stands_for[RESOURCES]; /* what passes that do not run write -> what stands for it */
    double settings[COUNT(SSAO_SETTINGS)];
    Numbers view[SSAO_VIEWS];
    int pinhole;
};

static char message[1024];

const char *ssao_error(void) { return message; }

static int fail(const char *format, ...) {
    va_list more;
    va_start(more, format);
    vsnprintf(message, sizeof message, format, more);
    va_end(more);
    return 0;
}

static int texels(const Ssao *ssao, int scale, int axis) { return (ssao->size[axis] + scale - 1) / scale; }

static Numbers view_value(const Ssao *ssao, const SsaoStep *step, const SsaoPart *part) {
    double w = texels(ssao, step->scale, 0), h = texels(ssao, step->scale, 1);
    switch (part->what) {
    case SSAO_VIEW_TARGET_SIZE: return numbers(2, w, h);
    case SSAO_VIEW_TARGET_TEXEL: return numbers(2, 1 / w, 1 / h);
    case SSAO_VIEW_TARGET_STEP: return numbers(2, step->scale / (double)ssao->size[0], step->scale / (double)ssao->size[1]);
    case SSAO_VIEW_RESOURCE_SIZE: {
        int scale = SSAO_SLOTS[SSAO_RESOURCE_SLOTS[part->resource]].scale;
        return numbers(2, (double)texels(ssao, scale, 0), (double)texels(ssao, scale, 1));
    }
    }
    return ssao->view[part->what];
}

/* Append the numbers of one part to those of a uniform. */
static int evaluate(const Ssao *ssao, const SsaoStep *step, const SsaoPart *part, float *out) {
    Numbers value = part->kind == SSAO_VIEW ? view_value(ssao, step, part) : numbers(1, 1.0);
    double times = part->factor * (part->kind == SSAO_SETTING ? ssao->settings[part->what] : 1);
    if (part->by >= 0) times *= ssao->settings[part->by];
    for (int i = 0; i < value.count; i++) {
        double scaled = times * value.v[i];
        out[i] = (float)(part->axis >= 0 && part->axis != i ? 0 : part->inverse ? 1 / scaled : scaled);
    }
    return value.count;
}

static void set_uniform(const Ssao *ssao, const SsaoStep *step, GLuint program, const SsaoUniform *uniform) {
    GLint at = glGetUniformLocation(program, uniform->name), size, count = 0;
    GLuint index;
    GLenum type;
    char name[128];
    float v[1024];
    snprintf(name, sizeof name, "%s[0]", uniform->name);
    const char *both[] = {uniform->name, name};
    index = GL_INVALID_INDEX;
    for (int i = 0; i < 2 && index == GL_INVALID_INDEX; i++) glGetUniformIndices(program, 1, &both[i], &index);
    if (at < 0 || index == GL_INVALID_INDEX) return; /* the compiler has left it out */
    glGetActiveUniform(program, index, sizeof name, NULL, &size, &type, name);
    for (int i = 0; i < uniform->count && count < COUNT(v) - 16; i++) count += evaluate(ssao, step, &SSAO_PARTS[uniform->first + i], v + count);
    switch (type) {
    case GL_FLOAT: glUniform1fv(at, count, v); break;
    case GL_FLOAT_VEC2: glUniform2fv(at, count / 2, v); break;
    case GL_FLOAT_VEC3: glUniform3fv(at, count / 3, v); break;
    case GL_FLOAT_VEC4: glUniform4fv(at, count / 4, v); break;
    case GL_FLOAT_MAT2: glUniformMatrix2fv(at, count / 4, GL_FALSE, v); break;
    case GL_FLOAT_MAT4: glUniformMatrix4fv(at, count / 16, GL_FALSE, v); break;
    }
}

static char *read_text(const char *folder, const char *name) {
    char path[4096], *text = NULL;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (file && !fseek(file, 0, SEEK_END)) {
        long length = ftell(file);
        rewind(file);
        text = length >= 0 ? calloc((size_t)length + 1, 1) : NULL;
        if (text && fread(text, 1, (size_t)length, file) != (size_t)length) { free(text); text = NULL; }
    }
    if (file) fclose(file);
    if (!text) fail("cannot read the shader %s", path);
    return text;
}

/* Attach a shader; what the projection decides is defined behind the first line, which is the version. */
static int attach(const Ssao *ssao, GLuint program, GLenum kind, const char *name) {
    char *text = read_text(ssao->folder, name), *rest = text ? strchr(text, '\n') : NULL;
    if (!rest) { free(text); return 0; }
    const char *parts[] = {text, ssao->pinhole ? "\n#define PINHOLE 1" : "", rest};
    GLint lengths[] = {(GLint)(rest - text), -1, -1}, done = 0;
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 3, parts, lengths);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) {
        char log[512] = "";
        glGetShaderInfoLog(shader, sizeof log, NULL, log);
        fail("%s: %s", name, log);
    }
    glAttachShader(program, shader);
    glDeleteShader(shader);
    free(text);
    return done;
}

static GLuint program_of(Ssao *ssao, int index) {
    GLuint *made = &ssao->programs[index][ssao->pinhole];
    if (*made) return *made;
    GLuint program = glCreateProgram();
    GLint done = attach(ssao, program, GL_VERTEX_SHADER, SSAO_VERTEX) && attach(ssao, program, GL_FRAGMENT_SHADER, SSAO_STEPS[index].shader);
    if (done) {
        glBindAttribLocation(program, 0, "a_corner");
        glLinkProgram(program);
        glGetProgramiv(program, GL_LINK_STATUS, &done);
        if (!done) fail("%s cannot be linked", SSAO_STEPS[index].shader);
    }
    if (!done) { glDeleteProgram(program); return 0; }
    return *made = program;
}

static GLuint new_texture(GLenum format, int width, int height) {
    GLuint made;
    glGenTextures(1, &made);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, made);
    glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    return made;
}

static GLuint new_sampler(GLint wrap) {
    GLuint made;
    glGenSamplers(1, &made);
    glSamplerParameteri(made, GL_TEXTURE_WRAP_S, wrap);
    glSamplerParameteri(made, GL_TEXTURE_WRAP_T, wrap);
    glSamplerParameteri(made, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glSamplerParameteri(made, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return made;
}

static void free_frame(Ssao *ssao) {
    glDeleteFramebuffers(STEPS, ssao->framebuffers);
    memset(ssao->framebuffers, 0, sizeof ssao->framebuffers);
    for (int i = 0; i < SLOTS; i++) {
        if (SSAO_SLOTS[i].format == GL_DEPTH_COMPONENT24) glDeleteRenderbuffers(1, &ssao->slots[i]);
        else glDeleteTextures(1, &ssao->slots[i]);
        ssao->slots[i] = 0;
    }
}

static GLuint slot_of(Ssao *ssao, int index) {
    const SsaoSlot *slot = &SSAO_SLOTS[index];
    int w = texels(ssao, slot->scale, 0), h = texels(ssao, slot->scale, 1);
    GLuint *made = &ssao->slots[index];
    if (*made) return *made;
    if (slot->format != GL_DEPTH_COMPONENT24) return *made = new_texture(slot->format, w, h);
    glGenRenderbuffers(1, made);
    glBindRenderbuffer(GL_RENDERBUFFER, *made);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, w, h);
    return *made;
}

/* Whether a step has something to do at this size; else what it samples stands for what it writes. */
static int runs(const Ssao *ssao, const SsaoStep *step) {
    return (step->least[0] && ssao->size[0] >= step->least[0]) || (step->least[1] && ssao->size[1] >= step->least[1]);
}

int ssao_resize(Ssao *ssao, int width, int height) {
    GLint most;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    most = most < SSAO_LARGEST ? most : SSAO_LARGEST;
    if (width < 1 || height < 1 || width > most || height > most) return fail("%dx%d: sides must be 1 to %d pixels", width, height, most);
    free_frame(ssao);
    ssao->size[0] = width;
    ssao->size[1] = height;
    for (int i = 0; i < RESOURCES; i++) ssao->stands_for[i] = i;
    for (int i = 0; i < STEPS; i++) {
        const SsaoStep *step = &SSAO_STEPS[i];
        if (!runs(ssao, step)) {
            ssao->stands_for[step->writes[0]] = ssao->stands_for[SSAO_SAMPLERS[step->samplers.first].index];
            continue;
        }
        GLenum targets[4];
        glGenFramebuffers(1, &ssao->framebuffers[i]);
        glBindFramebuffer(GL_FRAMEBUFFER, ssao->framebuffers[i]);
        for (int t = 0; t < step->write_count; t++) {
            targets[t] = GL_COLOR_ATTACHMENT0 + (GLenum)t;
            glFramebufferTexture2D(GL_FRAMEBUFFER, targets[t], GL_TEXTURE_2D, slot_of(ssao, SSAO_RESOURCE_SLOTS[step->writes[t]]), 0);
        }
        glDrawBuffers(step->write_count, targets);
        if (step->depth_slot >= 0)
            glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, slot_of(ssao, step->depth_slot));
        if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
            free_frame(ssao);
            ssao->size[0] = 0;
            return fail("pass '%s': this driver cannot draw into its targets; float targets need EXT_color_buffer_float", step->name);
        }
    }
    return 1;
}

Ssao *ssao_new(const char *folder) {
    static const float corners[] = {-1, -1, 3, -1, -1, 3};
    static const GLenum layouts[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA}, formats[] = {GL_R32F, GL_RG32F, GL_RGB32F, GL_RGBA32F};
    Ssao *ssao = calloc(1, sizeof *ssao);
    char *copy = calloc(strlen(folder) + 1, 1);
    if (!ssao || !copy) { free(ssao); free(copy); fail("out of memory"); return NULL; }
    ssao->folder = strcpy(copy, folder);
    for (int i = 0; i < COUNT(SSAO_SETTINGS); i++) ssao->settings[i] = SSAO_SETTINGS[i].value;
    ssao->clamp = new_sampler(GL_CLAMP_TO_EDGE);
    ssao->repeat = new_sampler(GL_REPEAT);
    for (int i = 0; i < COUNT(SSAO_TABLES) && SSAO_TABLES[i].data; i++) {
        const SsaoTable *table = &SSAO_TABLES[i];
        ssao->tables[i] = new_texture(formats[table->channels - 1], table->width, table->height);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, table->width, table->height, layouts[table->channels - 1], GL_FLOAT, table->data);
    }
    glGenVertexArrays(1, &ssao->vao);
    glBindVertexArray(ssao->vao);
    glGenBuffers(1, &ssao->corners);
    glBindBuffer(GL_ARRAY_BUFFER, ssao->corners);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    return ssao;
}

int ssao_set(Ssao *ssao, const char *name, double value) {
    for (int i = 0; i < COUNT(SSAO_SETTINGS); i++) {
        const SsaoSetting *setting = &SSAO_SETTINGS[i];
        if (!setting->name || strcmp(setting->name, name)) continue;
        if (!(value > setting->above && value >= setting->low && value <= setting->high)) return fail("%s=%g: is out of range", name, value);
        ssao->settings[i] = value;
        return 1;
    }
    return fail("'%s' cannot change", name);
}

static void bind(GLuint program, int unit, const char *uniform, GLuint texture, GLuint sampler) {
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(GL_TEXTURE_2D, texture);
    glBindSampler((GLuint)unit, sampler);
    glUniform1i(glGetUniformLocation(program, uniform), unit);
}

static int draw(Ssao *ssao, int index, const GLuint *given) {
    const SsaoStep *step = &SSAO_STEPS[index];
    GLuint program = program_of(ssao, index);
    int unit = 0;
    if (!program) return 0;
    glUseProgram(program);
    for (int i = 0; i < step->samplers.count; i++) {
        const SsaoSampler *one = &SSAO_SAMPLERS[step->samplers.first + i];
        int resource = ssao->stands_for[one->index];
        bind(program, unit++, one->uniform, resource < SSAO_INPUTS ? given[resource] : ssao->slots[SSAO_RESOURCE_SLOTS[resource]], ssao->clamp);
    }
    for (int i = 0; i < step->tables.count; i++) {
        const SsaoSampler *one = &SSAO_SAMPLERS[step->tables.first + i];
        bind(program, unit++, one->uniform, ssao->tables[one->index], ssao->repeat);
    }
    for (int i = 0; i < SSAO_STANDARD.count; i++) set_uniform(ssao, step, program, &SSAO_UNIFORMS[SSAO_STANDARD.first + i]);
    for (int i = 0; i < step->uniforms.count; i++) set_uniform(ssao, step, program, &SSAO_UNIFORMS[step->uniforms.first + i]);
    glBindFramebuffer(GL_FRAMEBUFFER, ssao->framebuffers[index]);
    glViewport(0, 0, texels(ssao, step->scale, 0), texels(ssao, step->scale, 1));
    for (int i = 0; i < step->write_count; i++) if (step->clears[i]) glClearBufferfv(GL_COLOR, i, step->clear[i]);
    if (step->depth_slot >= 0) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask((GLboolean)step->depth_writes);
        glDepthFunc(step->depth_passes);
    }
    glBindVertexArray(ssao->vao);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_DEPTH_TEST);
    return 1;
}

GLuint ssao_apply(Ssao *ssao, const SsaoInputs *inputs) {
    const GLuint given[SSAO_INPUTS] = {inputs->depth, inputs->normals, inputs->color};
    static const char *names[SSAO_INPUTS] = {"depth", "normals", "color"};
    if (!ssao->size[0]) return (GLuint)fail("call ssao_resize first");
    for (int i = 0; i < SSAO_INPUTS; i++)
        if (!given[i] != !SSAO_TAKES[i]) return (GLuint)fail(SSAO_TAKES[i] ? "%s: expected a texture" : "%s: this pipeline takes none", names[i]);
    const char *why = look(inputs->projection, ssao->size, ssao->view, &ssao->pinhole);
    if (why) return (GLuint)fail("%s", why);
    for (int i = 0; i < STEPS; i++) if (ssao->framebuffers[i] && !draw(ssao, i, given)) return 0;
    return ssao->slots[SSAO_RESOURCE_SLOTS[SSAO_OUTPUT]];
}

void ssao_free(Ssao *ssao) {
    if (!ssao) return;
    free_frame(ssao);
    for (int i = 0; i < STEPS; i++) for (int p = 0; p < 2; p++) glDeleteProgram(ssao->programs[i][p]);
    glDeleteTextures(COUNT(ssao->tables), ssao->tables);
    glDeleteSamplers(1, &ssao->clamp);
    glDeleteSamplers(1, &ssao->repeat);
    glDeleteVertexArrays(1, &ssao->vao);
    glDeleteBuffers(1, &ssao->corners);
    free(ssao->folder);
    free(ssao);
}
