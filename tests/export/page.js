// What tests do in the page: textures from bytes, a frame from a job, GL state.
export function context() {
    const canvas = document.createElement("canvas");
    return canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
}

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

export function texture(gl, [w, h], kind, text) {
    const [internal, layout, type, Kind] = {
        window: [gl.DEPTH_COMPONENT32F, gl.DEPTH_COMPONENT, gl.FLOAT, Float32Array],
        eye: [gl.R32F, gl.RED, gl.FLOAT, Float32Array],
        normals: [gl.RGBA32F, gl.RGBA, gl.FLOAT, Float32Array],
        color: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, Uint8Array],
    }[kind];
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, w, h, 0, layout, type, new Kind(bytes(text).buffer));
    // As a shadow map has it: the runtime must not be misled.
    if (kind === "window") gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.bindTexture(gl.TEXTURE_2D, null);
    return made;
}

export function inputs(gl, job) {
    const { size, depth, normals, color, projection, clip } = job;
    return {
        depth: texture(gl, size, job.window ? "window" : "eye", depth),
        ...(normals && { normals: texture(gl, size, "normals", normals) }),
        ...(color && { color: texture(gl, size, "color", color) }),
        projection,
        clip,
    };
}

export function read(gl, texture, [w, h]) {
    const framebuffer = gl.createFramebuffer(), rgba = new Uint8Array(4 * w * h);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    if (texture) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    else gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(framebuffer);
    let text = "";
    for (const value of rgba) text += String.fromCharCode(value);
    return btoa(text);
}

// Draw a job; bytes of the result in base 64.
export function draw(gl, ao, job) {
    const given = inputs(gl, job);
    ao.resize(...job.size);
    const result = read(gl, ao.apply(given), job.size);
    for (const name of ["depth", "normals", "color"]) gl.deleteTexture(given[name] ?? null);
    const error = gl.getError();
    if (error) throw new Error(`GL error ${error}`);
    return result;
}

const same = (a, b) => a === b || (a?.length !== undefined && typeof a !== "string" && String(Array.from(a)) === String(Array.from(b)));

// Every value that getters of WebGL2 give, by name.
function state(gl) {
    const found = {}, unit = gl.getParameter(gl.ACTIVE_TEXTURE);
    for (const name in WebGL2RenderingContext) {
        const constant = WebGL2RenderingContext[name];
        if (typeof constant !== "number" || constant < 0x0b00) continue;
        const value = gl.getParameter(constant);
        if (gl.getError() === gl.NO_ERROR) found[name] = value;
    }
    for (let i = 0; i < gl.getParameter(gl.MAX_TEXTURE_IMAGE_UNITS); i++) {
        gl.activeTexture(gl.TEXTURE0 + i);
        for (const name of ["TEXTURE_BINDING_2D", "TEXTURE_BINDING_3D", "TEXTURE_BINDING_CUBE_MAP", "TEXTURE_BINDING_2D_ARRAY", "SAMPLER_BINDING"]) {
            found[`${name} ${i}`] = gl.getParameter(gl[name]);
        }
    }
    gl.activeTexture(unit);
    return found;
}

// Bring the context out of its usual state; return what holds the objects.
function disturb(gl) {
    for (const name of ["BLEND", "CULL_FACE", "DEPTH_TEST", "POLYGON_OFFSET_FILL", "SAMPLE_COVERAGE", "SAMPLE_ALPHA_TO_COVERAGE", "SCISSOR_TEST", "STENCIL_TEST", "RASTERIZER_DISCARD"]) gl.enable(gl[name]);
    gl.disable(gl.DITHER);
    gl.viewport(3, 4, 5, 6); gl.scissor(1, 2, 3, 4); gl.depthRange(0.25, 0.5); gl.depthFunc(gl.NEVER); gl.depthMask(false);
    gl.colorMask(false, true, false, true); gl.clearColor(0.1, 0.2, 0.3, 0.4); gl.blendFunc(gl.ONE, gl.SRC_ALPHA);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2); gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 77); gl.pixelStorei(gl.UNPACK_SKIP_ROWS, 3);
    gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, 2); gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true); gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    for (let i = 0; i < 8; i++) {
        gl.activeTexture(gl.TEXTURE0 + i);
        gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
        gl.bindSampler(i, gl.createSampler());
    }
    gl.activeTexture(gl.TEXTURE0 + 5);
    gl.bindVertexArray(gl.createVertexArray());
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, gl.createBuffer());
    gl.bindBuffer(gl.UNIFORM_BUFFER, gl.createBuffer());
    gl.bindRenderbuffer(gl.RENDERBUFFER, gl.createRenderbuffer());
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, gl.createFramebuffer());
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, gl.createFramebuffer());
    feedback(gl);
}

// A program in use whose outputs are being captured.
function feedback(gl) {
    const program = gl.createProgram();
    for (const [kind, text] of [["VERTEX_SHADER", "out float v; void main() { v = 1.0; gl_Position = vec4(0.0); }"], ["FRAGMENT_SHADER", "precision highp float; in float v; out vec4 c; void main() { c = vec4(v); }"]]) {
        const shader = gl.createShader(gl[kind]);
        gl.shaderSource(shader, `#version 300 es\n${text}`);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    }
    gl.transformFeedbackVaryings(program, ["v"], gl.INTERLEAVED_ATTRIBS);
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, gl.createTransformFeedback());
    const buffer = gl.createBuffer();
    gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, 64, gl.STATIC_DRAW);
    gl.beginTransformFeedback(gl.POINTS);
}

// Names of getters that give something else after each call of the runtime, and how many there are.
export function stateAfter(pipeline, job) {
    const gl = context(), given = inputs(gl, job);
    disturb(gl);
    const before = state(gl), different = new Set();
    const compare = (when) => {
        const error = gl.getError(), after = state(gl);
        if (error) different.add(`${when}: error ${error}`);
        for (const name in before) if (!same(before[name], after[name])) different.add(`${when}: ${name}`);
    };
    const ao = new SsaoGl(gl, pipeline);
    compare("new");
    ao.resize(...job.size);
    for (const target of [undefined, null]) { ao.apply({ ...given, target }); compare(`apply ${target}`); }
    try { ao.apply({ ...given, projection: [] }); } catch { compare("error"); }
    ao.resize(7, 5);
    ao.dispose();
    compare("dispose");
    gl.endTransformFeedback();
    return [[...different], Object.keys(before).length];
}

const KINDS = ["Texture", "Framebuffer", "Renderbuffer", "Program", "Sampler", "Buffer", "VertexArray", "Shader"];

// Objects alive, by kind, from now on.
function counted(gl) {
    const alive = Object.fromEntries(KINDS.map((kind) => [kind, 0]));
    for (const kind of KINDS) {
        for (const [verb, step] of [["create", 1], ["delete", -1]]) {
            const call = gl[verb + kind].bind(gl);
            gl[verb + kind] = (...args) => { if (verb === "create" || args[0]) alive[kind] += step; return call(...args); };
        }
    }
    return alive;
}

export function leaks(pipeline, job, frames) {
    const gl = context(), alive = counted(gl);
    const sizes = [[16, 12], [9, 5], [33, 20]].map(([w, h]) => {
        const make = (format) => {
            const made = gl.createTexture();
            gl.bindTexture(gl.TEXTURE_2D, made);
            gl.texStorage2D(gl.TEXTURE_2D, 1, format, w, h);
            return made;
        };
        return { w, h, depth: make(gl.DEPTH_COMPONENT32F), color: make(gl.RGBA8) };
    });
    const ao = new SsaoGl(gl, pipeline), early = {};
    for (const kind of KINDS) alive[kind] -= kind === "Texture" ? 6 : 0;
    for (let i = 0; i < frames; i++) {
        const { w, h, depth, color } = sizes[(i >> 2) % 3];
        ao.resize(w, h);
        if (i % 7 === 0) ao.set({ radius: 0.5 + i / frames });
        ao.apply({ depth, color, projection: job.projection, clip: job.clip });
        if (i === 1) Object.assign(early, alive);
    }
    gl.finish();
    const late = { ...alive };
    ao.dispose();
    ao.dispose();
    return [early, late, alive];
}

// A browser that cannot draw into one of the targets: what two calls say, and how many objects are left behind.
export function refused(pipeline, job) {
    const gl = context(), ao = new SsaoGl(gl, pipeline), given = inputs(gl, job), alive = counted(gl);
    gl.checkFramebufferStatus = () => gl.FRAMEBUFFER_UNSUPPORTED;
    ao.resize(...job.size);
    const said = [1, 2].map(() => {
        try {
            return ao.apply(given) && "nothing";
        } catch (error) {
            return error.message;
        }
    });
    return [said, alive];
}

export async function lose(pipeline, job) {
    const gl = context(), ao = new SsaoGl(gl, pipeline), before = draw(gl, ao, job);
    const extension = gl.getExtension("WEBGL_lose_context");
    const heard = (name) => new Promise((done) => gl.canvas.addEventListener(name, () => setTimeout(done), { once: true }));
    const lost = heard("webglcontextlost");
    extension.loseContext();
    await lost;
    ao.resize(8, 8);
    const during = ao.apply({ depth: {}, color: {}, projection: job.projection, clip: job.clip });
    const back = heard("webglcontextrestored");
    extension.restoreContext();
    await back;
    return [before, during, draw(gl, ao, job)];
}

// Whether the canvas and a framebuffer of the caller's hold what the result's texture holds.
export function toTarget(pipeline, job) {
    const gl = context(), given = inputs(gl, job), ao = new SsaoGl(gl, pipeline), framebuffer = gl.createFramebuffer(), own = texture(gl, job.size, "color", job.color);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, own, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    ao.resize(...job.size);
    [gl.canvas.width, gl.canvas.height] = job.size;
    return [null, framebuffer].map((target) => {
        const result = read(gl, ao.apply({ ...given, target }), job.size);
        return read(gl, target && own, job.size) === result;
    });
}

// A context that lacks an extension.
function without(gl, name) {
    const get = gl.getExtension.bind(gl);
    gl.getExtension = (asked) => (asked === name ? null : get(asked));
    return gl;
}

// What an expression throws.
export function mistake(made, code) {
    const ao = new SsaoGl(gl, made), sized = new SsaoGl(gl, made), gone = new SsaoGl(gl, made);
    const depth = gl.createTexture(), projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.02, -1, 0, 0, -1, 0];
    sized.resize(8, 8);
    gone.resize(8, 8);
    gone.dispose();
    try {
        new Function("SsaoGl", "gl", "made", "ao", "sized", "gone", "depth", "projection", "without", "context", code)(SsaoGl, gl, made, ao, sized, gone, depth, projection, without, context);
        return "nothing";
    } catch (error) {
        return error.message;
    } finally {
        [ao, sized].forEach((one) => one.dispose());
        gl.deleteTexture(depth);
    }
}
