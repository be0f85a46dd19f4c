// Ambient occlusion on WebGL2: runs a pipeline that `ssao-gl export --target webgl2` wrote. No dependencies.
// A pipeline is data (pipeline.schema.json describes it); this module computes its view values and draws its steps.

const FORMAT = "ssao_gl pipeline 1";
const SETTERS = {
    FLOAT: "1fv", FLOAT_VEC2: "2fv", FLOAT_VEC3: "3fv", FLOAT_VEC4: "4fv", FLOAT_MAT2: "Matrix2fv", FLOAT_MAT4: "Matrix4fv",
};
const CAPABILITIES = [
    "BLEND", "CULL_FACE", "DEPTH_TEST", "DITHER", "POLYGON_OFFSET_FILL", "RASTERIZER_DISCARD", "SAMPLE_ALPHA_TO_COVERAGE",
    "SAMPLE_COVERAGE", "SCISSOR_TEST", "STENCIL_TEST",
];
const UNPACK = {
    UNPACK_ALIGNMENT: 4, UNPACK_ROW_LENGTH: 0, UNPACK_SKIP_ROWS: 0, UNPACK_SKIP_PIXELS: 0, UNPACK_FLIP_Y_WEBGL: 0,
    UNPACK_PREMULTIPLY_ALPHA_WEBGL: 0,
};
const FOUR = [0, 1, 2, 3];
const { entries, assign, values } = Object;

const fail = (text) => {
    throw new Error(`SsaoGl: ${text}`);
};

// Inverse of a 4x4 matrix m(row, column), by Gauss and Jordan with the largest pivot of each column.
function inverse(m) {
    const a = FOUR.map((r) => [...FOUR.map((c) => m(r, c)), ...FOUR.map((c) => +(c === r))]);
    for (const c of FOUR) {
        const p = FOUR.slice(c).reduce((best, r) => (Math.abs(a[r][c]) > Math.abs(a[best][c]) ? r : best), c);
        [a[c], a[p]] = [a[p], a[c]];
        const pivot = a[c][c];
        if (!pivot) fail("the projection cannot be inverted");
        a[c] = a[c].map((v) => v / pivot);
        for (const r of FOUR) {
            const f = a[r][c];
            if (r !== c) a[r] = a[r].map((v, i) => v - f * a[c][i]);
        }
    }
    return (r, c) => a[r][4 + c];
}

// What depends on the projection m(row, column) and the size alone, by the names of the schema.
function viewValues(m, [width, height]) {
    const det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0), w1 = -m(3, 2), w0 = m(3, 3);
    if (!det || m(3, 0) || m(3, 1)) fail("the projection flattens the image, or w depends on x or y");
    if (w1 < 0) fail("the projection looks along +z; view space looks along -z");
    const [a, b, c, d] = [m(1, 1), -m(1, 0), -m(0, 1), m(0, 0)].map((v) => v / det); // inverse of xy, column by column
    const times = (x, y) => [a * x + c * y, b * x + d * y];
    const un = inverse(m);
    // Linear depth of window depth 0 and 1 in the middle of the image; what floats leave of an infinite far plane is tiny.
    const tiny = 1e-13 * Math.max(...FOUR.map((i) => Math.abs(un(3, i))));
    const planes = [-1, 1].map((ndc) => {
        const w = un(3, 2) * ndc + un(3, 3);
        return Math.abs(w) > tiny ? -(un(2, 2) * ndc + un(2, 3)) / w : Infinity;
    });
    const far = +(planes[1] > planes[0]);
    const row = (r) => [2 * un(r, 0), 2 * un(r, 1), 2 * un(r, 2), un(r, 3) - un(r, 0) - un(r, 1) + un(r, 2) * (2 * far - 1)];
    const den = row(3), scale = Math.max(...den.map(Math.abs)) || 1;
    return {
        pinhole: !w0 && !m(0, 3) && !m(1, 3),
        far: planes[far],
        pixel: Math.max(2 * Math.hypot(a, b) / width, 2 * Math.hypot(c, d) / height),
        inverse_projection: FOUR.flatMap((i) => FOUR.map((r) => un(r, i))),
        image_size: [width, height],
        image_texel: [1 / width, 1 / height],
        image_share: [1, 1],
        window_depth_far: far,
        window_depth_num: row(2).map((v) => -v / scale),
        window_depth_den: den.map((v) => v / scale),
        ray: [a, b, c, d].map((v) => 2 * w1 * v),
        ray0: times(m(0, 2) - w1, m(1, 2) - w1),
        org: [a, b, c, d].map((v) => 2 * w0 * v),
        org0: times(-m(0, 3) - w0, -m(1, 3) - w0),
        clip_w: [w1, w0],
        uv_per_unit: [m(0, 0), m(1, 0), m(0, 1), m(1, 1)].map((v) => v / 2),
    };
}

// Remember the caller's state, set what passes expect, and return what puts it back.
function guest(gl, units) {
    const get = (name) => gl.getParameter(gl[name]);
    const feedback = get("TRANSFORM_FEEDBACK_ACTIVE") && !get("TRANSFORM_FEEDBACK_PAUSED");
    if (feedback) gl.pauseTransformFeedback(); // or no program could be used
    const undo = [];
    const keep = (name, put) => {
        const value = get(name);
        undo.push(() => put(value));
    };
    for (const name of CAPABILITIES) {
        if (gl.isEnabled(gl[name])) undo.push(() => gl.enable(gl[name]));
        else undo.push(() => gl.disable(gl[name]));
        gl.disable(gl[name]);
    }
    for (const [name, value] of entries(UNPACK)) {
        keep(name, (v) => gl.pixelStorei(gl[name], v));
        gl.pixelStorei(gl[name], value);
    }
    const unit = get("ACTIVE_TEXTURE");
    for (let i = 0; i < units; i++) {
        gl.activeTexture(gl.TEXTURE0 + i);
        keep("TEXTURE_BINDING_2D", (v) => { gl.activeTexture(gl.TEXTURE0 + i); gl.bindTexture(gl.TEXTURE_2D, v); });
        keep("SAMPLER_BINDING", (v) => gl.bindSampler(i, v));
    }
    undo.push(() => gl.activeTexture(unit));
    keep("CURRENT_PROGRAM", (v) => gl.useProgram(v));
    keep("VERTEX_ARRAY_BINDING", (v) => gl.bindVertexArray(v));
    keep("ARRAY_BUFFER_BINDING", (v) => gl.bindBuffer(gl.ARRAY_BUFFER, v));
    keep("PIXEL_UNPACK_BUFFER_BINDING", (v) => gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, v));
    keep("RENDERBUFFER_BINDING", (v) => gl.bindRenderbuffer(gl.RENDERBUFFER, v));
    keep("DRAW_FRAMEBUFFER_BINDING", (v) => gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, v));
    keep("READ_FRAMEBUFFER_BINDING", (v) => gl.bindFramebuffer(gl.READ_FRAMEBUFFER, v));
    keep("VIEWPORT", (v) => gl.viewport(...v));
    keep("DEPTH_RANGE", (v) => gl.depthRange(...v));
    keep("COLOR_WRITEMASK", (v) => gl.colorMask(...v));
    keep("DEPTH_WRITEMASK", (v) => gl.depthMask(v));
    keep("DEPTH_FUNC", (v) => gl.depthFunc(v));
    const clip = gl.getExtension("EXT_clip_control"); // passes that test depth stand half way in -1..1
    if (clip) {
        const is = [0x935c, 0x935d].map((name) => gl.getParameter(name)); // CLIP_ORIGIN_EXT, CLIP_DEPTH_MODE_EXT
        undo.push(() => clip.clipControlEXT(...is));
        clip.clipControlEXT(0x8ca1, 0x935e); // LOWER_LEFT_EXT, NEGATIVE_ONE_TO_ONE_EXT
    }
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    gl.colorMask(true, true, true, true);
    gl.depthRange(0, 1);
    if (feedback) undo.push(() => gl.resumeTransformFeedback());
    return () => {
        if (!gl.isContextLost()) undo.forEach((put) => put());
    };
}

export class SsaoGl {
    #gl; #pipeline; #units; #heard;
    #size; // [width, height], pixels
    #made; // GL objects that no size changes
    #frame; // those of one size
    #live = {}; // settings
    #view = {}; // values of the last projection
    #version = 0; // of view and settings: programs whose uniforms are of another one are set again

    constructor(gl, pipeline) {
        if (!gl?.createSampler) fail("expected a WebGL2 context: canvas.getContext('webgl2')");
        if (pipeline?.format !== FORMAT) fail(`expected '${FORMAT}', got '${pipeline?.format}'`);
        this.#gl = gl;
        this.#pipeline = pipeline;
        this.#units = Math.max(...pipeline.steps.map((step) => values({ ...step.samplers, ...step.tables }).length));
        for (const name in pipeline.live) this.#live[name] = pipeline.live[name].value;
        if (!gl.isContextLost()) this.#guarded(() => this.#make());
        const forget = (event) => {
            event.preventDefault(); // or the context would never come back
            this.#made = this.#frame = null;
        };
        this.#heard = { webglcontextlost: forget, webglcontextrestored: forget };
        for (const name in this.#heard) gl.canvas.addEventListener(name, forget);
    }

    get settings() {
        return { ...this.#live };
    }

    set(settings) {
        const { live } = this.#pipeline;
        for (const name in settings) {
            const rule = live[name] ?? fail(`'${name}' cannot change; ${Object.keys(live)} can`);
            const parts = [settings[name]].flat();
            if (parts.length !== [rule.value].flat().length || !parts.every((v) => Number.isFinite(v) && !(v <= rule.above || v < rule.low || v > rule.high))) {
                fail(`${name}=${settings[name]}: is out of range`);
            }
        }
        assign(this.#live, settings);
        this.#version++;
    }

    resize(width, height) {
        const gl = this.#gl, most = Math.min(gl.getParameter(gl.MAX_TEXTURE_SIZE) ?? Infinity, this.#pipeline.largest);
        for (const side of [width, height]) {
            if (!(Number.isInteger(side) && side > 0 && side <= most)) fail(`resize(${width}, ${height}): expected whole pixels, 1 to ${most}`);
        }
        if (`${this.#size}` === `${[width, height]}`) return;
        this.#free(this.#frame);
        this.#frame = null;
        this.#size = [width, height];
        this.#view = {};
    }

    // Draw; return the texture of the result, valid until the next call, or null while the context is lost.
    apply({ depth, color, normals, projection, clip = "-1..1", target }) {
        const { inputs, output } = this.#pipeline, given = { depth, color, normals };
        if (!this.#heard) fail("was disposed");
        if (!this.#size) fail("call resize(width, height) first");
        for (const name in given) {
            if (!given[name] !== !inputs[name]) fail(`${name}: ${inputs[name] ? "expected a texture" : "export a pipeline that takes it"}`);
        }
        this.#look(Array.from(projection ?? []), clip);
        if (this.#gl.isContextLost()) return null;
        return this.#guarded(() => {
            this.#made ?? this.#make();
            this.#frame ?? this.#makeFrame();
            const { textures } = this.#frame;
            for (const name in inputs) textures[inputs[name].resource] = given[name];
            for (const step of this.#frame.steps) this.#draw(step);
            const result = textures[output.resource];
            // null is the canvas
            if (target !== undefined) this.#render(this.#program(this.#pipeline.copy, {}), [["u_image", result, 0]], target, this.#size, {});
            return result;
        });
    }

    dispose() {
        for (const name in this.#heard) this.#gl.canvas.removeEventListener(name, this.#heard[name]);
        this.#free(this.#frame);
        this.#free(this.#made);
        this.#heard = this.#frame = this.#made = null;
    }

    #free(objects) {
        for (const [kind, object] of objects?.owned ?? []) this.#gl[`delete${kind}`](object);
    }

    #guarded(work) {
        const restore = guest(this.#gl, this.#units);
        try {
            return work();
        } finally {
            restore();
        }
    }

    #look(matrix, clip) {
        const key = `${clip} ${matrix}`;
        if (this.#view.key === key) return;
        if (matrix.length !== 16 || !matrix.every(Number.isFinite)) fail("projection: expected 16 finite numbers, column by column");
        if (clip !== "-1..1" && clip !== "0..1") fail(`clip: expected '-1..1' or '0..1', got '${clip}'`);
        const m = (r, c) => matrix[4 * c + r];
        const view = viewValues((r, c) => (r === 2 && clip === "0..1" ? 2 * m(2, c) - m(3, c) : m(r, c)), this.#size);
        const has = { perspective: view.pinhole, "far plane": view.far < Infinity };
        for (const need of this.#pipeline.cameras) if (!has[need]) fail(`this method is for cameras with: ${need}`);
        this.#view = { ...view, key };
        this.#version++;
    }

    // Make an object that `objects` owns.
    #own(objects, kind, ...of) {
        const made = this.#gl[`create${kind}`](...of);
        objects.owned.push([kind, made]);
        return made;
    }

    #texture(objects, format, [width, height]) {
        const gl = this.#gl, texture = this.#own(objects, "Texture");
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texStorage2D(gl.TEXTURE_2D, 1, gl[format.toUpperCase()], width, height);
        return texture;
    }

    #target(objects, format, size) {
        if (format !== "depth24") return this.#texture(objects, format, size);
        const gl = this.#gl, buffer = this.#own(objects, "Renderbuffer");
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
        gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, ...size);
        return buffer;
    }

    #make() {
        const gl = this.#gl, { slots, tables } = this.#pipeline;
        // Asking for the extension also switches it on.
        if (slots.some(({ format }) => format.endsWith("f")) && !gl.getExtension("EXT_color_buffer_float")) {
            fail("no drawing into float textures here (EXT_color_buffer_float)");
        }
        const made = (this.#made = { owned: [], programs: {}, tables: {} });
        made.samplers = ["CLAMP_TO_EDGE", "REPEAT"].map((wrap) => {
            const sampler = this.#own(made, "Sampler");
            for (const side of "ST") gl.samplerParameteri(sampler, gl[`TEXTURE_WRAP_${side}`], gl[wrap]);
            for (const way of ["MIN", "MAG"]) gl.samplerParameteri(sampler, gl[`TEXTURE_${way}_FILTER`], gl.NEAREST);
            return sampler;
        });
        for (const name in tables) {
            const { width, height, channels, data } = tables[name], layout = ["RED", "RG", "RGB", "RGBA"][channels - 1];
            made.tables[name] = this.#texture(made, `${channels > 1 ? layout : "R"}32F`, [width, height]);
            gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl[layout], gl.FLOAT, new Float32Array(data));
        }
        made.vao = this.#own(made, "VertexArray");
        gl.bindVertexArray(made.vao);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.#own(made, "Buffer"));
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
        gl.enableVertexAttribArray(0);
        gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    }

    // Targets of one size. A step that has nothing to do there hands on what it samples.
    #makeFrame() {
        const gl = this.#gl, { slots, resources, steps } = this.#pipeline, also = {};
        const frame = { owned: [], steps: [], textures: {}, sizes: {} };
        const sized = (scale) => this.#size.map((side) => Math.ceil(side / scale));
        const made = [];
        const slot = (i) => (made[i] ??= this.#target(frame, slots[i].format, sized(slots[i].scale)));
        for (const name in resources) frame.sizes[name] = sized(slots[resources[name]].scale);
        for (const step of steps) {
            const { writes, depth, samplers } = step;
            if (step.when && !step.when.some((least, axis) => least && this.#size[axis] >= least)) {
                const [source] = values(samplers);
                also[writes[0]] = also[source] ?? source;
                continue;
            }
            const framebuffer = this.#own(frame, "Framebuffer");
            gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
            const targets = writes.map((_, i) => gl.COLOR_ATTACHMENT0 + i);
            targets.forEach((at, i) => {
                const texture = (frame.textures[writes[i]] = slot(resources[writes[i]]));
                gl.framebufferTexture2D(gl.FRAMEBUFFER, at, gl.TEXTURE_2D, texture, 0);
            });
            gl.drawBuffers(targets);
            if (depth) gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, slot(depth.slot));
            if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost()) {
                this.#free(frame);
                fail(`pass '${step.name}': this browser cannot draw into ${writes.map((name) => slots[resources[name]].format)}`);
            }
            const reads = entries(samplers).map(([uniform, name]) => [uniform, also[name] ?? name]);
            frame.steps.push({ ...step, framebuffer, reads, size: sized(step.scale) });
        }
        this.#frame = frame;
    }

    // The program of a fragment shader under some defines, for the kind of projection that there is.
    #program(shader, defines) {
        const gl = this.#gl, { vertex, version_line, shaders } = this.#pipeline, { programs } = this.#made;
        const lines = entries({ ...defines, ...(this.#view.pinhole && { PINHOLE: 1 }) }).map(([name, value]) => `#define ${name} ${value}\n`);
        const head = `${version_line}\n${lines.join("")}`, key = shader + head;
        if (programs[key]) return programs[key];
        const program = this.#own(this.#made, "Program");
        const parts = [["VERTEX_SHADER", vertex], ["FRAGMENT_SHADER", shader]].map(([kind, name]) => {
            const part = gl.createShader(gl[kind]);
            gl.shaderSource(part, head + shaders[name]);
            gl.compileShader(part);
            gl.attachShader(program, part);
            gl.deleteShader(part); // with the program
            return part;
        });
        gl.bindAttribLocation(program, 0, "a_corner");
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
            fail(`${shader}: ${[gl.getProgramInfoLog(program), ...parts.map((part) => gl.getShaderInfoLog(part))].join(" ")}`);
        }
        const uniforms = {};
        for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
            const { name, type } = gl.getActiveUniform(program, i);
            const setter = entries(SETTERS).find(([kind]) => gl[kind] === type)?.[1];
            uniforms[name.replace("[0]", "")] = { setter, at: gl.getUniformLocation(program, name) };
        }
        return (programs[key] = { program, uniforms });
    }

    #draw(step) {
        const gl = this.#gl, { textures } = this.#frame, { depth, framebuffer, clear } = step;
        const units = [...step.reads.map(([uniform, name]) => [uniform, textures[name], 0]),
            ...entries(step.tables ?? {}).map(([uniform, name]) => [uniform, this.#made.tables[name], 1])];
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        clear?.forEach((value, i) => value && gl.clearBufferfv(gl.COLOR, i, value));
        if (depth) {
            gl.enable(gl.DEPTH_TEST);
            gl.depthMask(depth.writes);
            gl.depthFunc(gl[depth.passes.toUpperCase()]);
        }
        this.#render(this.#program(step.shader, step.defines), units, framebuffer, step.size, step.uniforms, step);
        gl.disable(gl.DEPTH_TEST);
    }

    // One triangle over a framebuffer. units: [sampler uniform, texture, number of our sampler].
    #render(bound, units, framebuffer, size, uniforms, step) {
        const gl = this.#gl, version = this.#version;
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        gl.viewport(0, 0, ...size);
        gl.useProgram(bound.program);
        units.forEach(([, texture, sampler], i) => {
            gl.activeTexture(gl.TEXTURE0 + i);
            gl.bindTexture(gl.TEXTURE_2D, texture);
            gl.bindSampler(i, this.#made.samplers[sampler]);
        });
        if (bound.version !== version || bound.step !== step) { // else its uniforms are set
            units.forEach(([name], i) => bound.uniforms[name] && gl.uniform1i(bound.uniforms[name].at, i));
            for (const [name, value] of entries({ ...this.#pipeline.standard, ...uniforms })) {
                const { setter, at } = bound.uniforms[name] ?? {};
                if (setter) gl[`uniform${setter}`](at, ...(setter[0] === "M" ? [false] : []), this.#value(value, step));
            }
            assign(bound, { version, step });
        }
        gl.bindVertexArray(this.#made.vao);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    // A value of the schema as numbers.
    #value(value, step) {
        if (!(value instanceof Object)) return [value];
        if (Array.isArray(value)) return value.flatMap((part) => this.#value(part, step));
        const { setting, view, factor = 1, inverse, axis, resource, part = 0 } = value, [times] = this.#value(factor, step);
        const known = () => ({
            target_size: step.size,
            target_texel: step.size.map((side) => 1 / side),
            target_step: this.#size.map((side) => step.scale / side),
            resource_size: this.#frame.sizes[resource],
        })[view];
        return [setting ? [this.#live[setting]].flat()[part] : this.#view[view] ?? known()].flat().map((v, i) => {
            const scaled = inverse ? 1 / (times * v) : times * v;
            return i === (axis ?? i) ? scaled : 0;
        });
    }
}
