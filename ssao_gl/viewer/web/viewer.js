// A scene in a canvas, with ambient occlusion by SsaoGl: orbit, cameras, looks, before and after, buffers, rays beside it.
// Written for pages and for widgets of notebooks; the caller gives the element, the packed scene, and options as plain values.

export const unpacked = async (bytes) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());

const ARRAYS = { float32: Float32Array, int8: Int8Array, uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array };
const KEYS = [
    ["drag, arrows", "turn"], ["right drag, Shift+arrows, two fingers", "move"], ["wheel, + and -, pinch", "nearer, farther"],
    ["1 to 9", "cameras"], ["Home", "back to the camera"], ["v", "next picture"], ["o", "occlusion on and off"],
    ["c", "compare: wipe"], ["[ and ]", "move the wipe"], ["h", "hide the panel"],
];
const STYLE = `
.ssao { --ink: #22262b; --soft: #5d666f; --paper: #ffffffe8; --line: #d8dde2; --mark: #1b66b1; --room: #e9ecef;
  position: relative; display: flex; width: 100%; height: 100%; min-height: 16rem; overflow: hidden; background: var(--room);
  color: var(--ink); font: 14px/1.4 system-ui, sans-serif; }
@media (prefers-color-scheme: dark) {
  .ssao { --ink: #e4e7ea; --soft: #9aa4ae; --paper: #1d2125e8; --line: #3a4047; --mark: #7ab7f0; --room: #101214; }
}
.ssao .stage { position: relative; margin: auto; touch-action: none; }
.ssao canvas { display: block; width: 100%; height: 100%; cursor: grab; outline-offset: -2px; }
.ssao canvas:focus-visible { outline: 2px solid var(--mark); }
.ssao .edge { position: absolute; top: 0; bottom: 0; width: 24px; margin-left: -12px; cursor: ew-resize; touch-action: none; }
.ssao .edge::before { content: ""; position: absolute; left: 11px; width: 2px; top: 0; bottom: 0; background: var(--mark); }
.ssao .edge span { position: absolute; top: .6rem; padding: .1rem .5rem; background: var(--paper); border-radius: 4px; white-space: nowrap; }
.ssao .edge span:first-child { right: 20px; } .ssao .edge span:last-child { left: 20px; }
.ssao [hidden] { display: none !important; }
.ssao .panel { position: absolute; right: .6rem; top: .6rem; width: 15.5rem; max-height: calc(100% - 1.2rem); overflow: auto;
  box-sizing: border-box; padding: .5rem .8rem; background: var(--paper); border: 1px solid var(--line); border-radius: 8px; }
.ssao .panel > summary { cursor: pointer; font-weight: 600; overflow-wrap: anywhere; }
.ssao label { display: block; margin: .45rem 0; }
.ssao label > span { display: flex; justify-content: space-between; color: var(--soft); font-size: .85rem; }
.ssao output { font-variant-numeric: tabular-nums; }
.ssao select, .ssao input[type=range] { width: 100%; box-sizing: border-box; font: inherit; }
.ssao .note { color: var(--soft); font-size: .8rem; margin: .4rem 0; }
.ssao dl { display: grid; grid-template-columns: max-content 1fr; gap: 0 .6rem; font-size: .8rem; margin: .3rem 0; }
.ssao dd { margin: 0; color: var(--soft); }
@media (max-width: 640px) { .ssao .panel { width: 12.5rem; font-size: 13px; } }`;

// Matrices are 16 numbers, column by column, as WebGL takes them.
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const sum = (a, b, f = 1) => [a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const l = Math.hypot(...a) || 1; return a.map((v) => v / l); };
const column = (m, c) => Array.from(m.slice(4 * c, 4 * c + 3));
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

// World to view of a pose (camera to world).
function viewOf(pose) {
    const [x, y, z, at] = [0, 1, 2, 3].map((c) => column(pose, c));
    return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, at), -dot(y, at), -dot(z, at), 1];
}

const pose = (x, y, z, at) => [...x, 0, ...y, 0, ...z, 0, ...at, 1];

// Projection of a lens for an image of an aspect, with its clip planes around what there is to see.
function projectionOf(lens, aspect, near, far) {
    const d = far - near;
    if (lens.height) return [2 / (lens.height * aspect), 0, 0, 0, 0, 2 / lens.height, 0, 0, 0, 0, -2 / d, 0, 0, 0, -(far + near) / d, 1];
    if (lens.matrix) { // any other lens: its rows for x, y and w stay
        const m = [...lens.matrix], w = (z) => m[11] * -z + m[15], slope = (w(far) + w(near)) / d;
        [m[2], m[6], m[10], m[14]] = [0, 0, -slope, -w(near) - slope * near];
        return m;
    }
    const f = 1 / Math.tan(lens.yfov / 2);
    return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, -(far + near) / d, -1, 0, 0, -2 * far * near / d, 0];
}

const HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
`;
const SURFACE = `
layout(location = 0) out vec4 out_color;   // sRGB, and the direct light
layout(location = 1) out vec4 out_normal;  // view space, the triangle's own
const vec3 LIGHT = vec3(-0.36, 0.48, 0.8);
void write(vec3 color, vec3 geometric, vec3 n) {
    out_normal = vec4(geometric, 1.0);
    out_color = vec4(color, max(0.0, dot(n, LIGHT)));
}`;
const MESH = [`${HEAD}
uniform mat4 u_view, u_projection, u_place;
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_color;
out vec3 v_position, v_normal, v_color;
void main() {
    mat4 m = u_view * u_place;
    v_position = (m * vec4(a_position, 1.0)).xyz;
    v_normal = mat3(cross(m[1].xyz, m[2].xyz), cross(m[2].xyz, m[0].xyz), cross(m[0].xyz, m[1].xyz)) * a_normal;
    v_color = a_color.rgb;
    gl_Position = u_projection * vec4(v_position, 1.0);
}`, `${HEAD}${SURFACE}
uniform vec3 u_color;
in vec3 v_position, v_normal, v_color;
void main() {
    vec3 face = cross(dFdx(v_position), dFdy(v_position));
    vec3 seen = dot(face, v_position) > 0.0 ? -face : face;
    seen /= max(max(abs(seen.x), abs(seen.y)), max(abs(seen.z), 1e-37));
    vec3 geometric = dot(seen, seen) > 0.0 ? normalize(seen) : vec3(0.0, 0.0, 1.0), n = geometric;
    if (dot(v_normal, v_normal) > 0.0) {
        n = normalize(v_normal);
        n = dot(n, geometric) < 0.0 ? -n : n;
    }
    write(u_color * v_color, geometric, n);
}`];
const SPHERES = [`${HEAD}
uniform mat4 u_view, u_projection, u_place;
layout(location = 0) in vec4 a_ball;
layout(location = 2) in vec4 a_color;
flat out vec4 v_ball;
flat out vec3 v_color;
out vec3 v_position;
void main() {
    mat4 m = u_view * u_place;
    vec3 center = (m * vec4(a_ball.xyz, 1.0)).xyz;
    v_ball = vec4(center, a_ball.w * length(m[0].xyz));
    v_color = a_color.rgb;
    // A square before the ball, across the way to it, as wide as the cone that touches it.
    bool parallel = u_projection[2].w == 0.0;
    vec3 away = parallel ? vec3(0.0, 0.0, -1.0) : normalize(center);
    float share = parallel ? 0.0 : min(v_ball.w / max(length(center), 1e-30), 0.99);
    vec3 x = normalize(abs(away.y) < 0.9 ? vec3(-away.z, 0.0, away.x) : vec3(0.0, away.z, -away.y)), y = cross(away, x);
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    float reach = v_ball.w * sqrt((1.0 - share) / (1.0 + share));
    v_position = center - away * v_ball.w + reach * 1.02 * (corner.x * x + corner.y * y);
    gl_Position = u_projection * vec4(v_position, 1.0);
}`, `${HEAD}${SURFACE}
uniform mat4 u_projection;
uniform vec3 u_color;
flat in vec4 v_ball;
flat in vec3 v_color;
in vec3 v_position;
void main() {
    vec3 ray = u_projection[2].w == 0.0 ? vec3(0.0, 0.0, -1.0) : normalize(v_position);
    vec3 from = (v_position - v_ball.xyz) / v_ball.w;
    float middle = dot(from, ray);
    vec3 closest = from - middle * ray;
    float inside = 1.0 - dot(closest, closest);
    if (inside < 0.0) discard;
    vec3 n = closest - sqrt(inside) * ray;
    vec4 clip = u_projection * vec4(v_ball.xyz + v_ball.w * n, 1.0);
    gl_FragDepth = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
    write(u_color * v_color, n, n);
}`];
const WHOLE = `${HEAD}
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;
const PICTURE = [WHOLE, `${HEAD}
uniform sampler2D u_color, u_depth, u_normal, u_visibility, u_truth;
uniform int u_show;         // 0 picture, 1 visibility, 2 depth, 3 normals
uniform int u_left;         // what is left of the wipe: 0 the same, 1 no occlusion, 2 rays
uniform float u_wipe, u_ambient, u_strength;
uniform vec2 u_size, u_range;  // pixels; linear depth near and far
uniform mat4 u_inverse;
uniform vec3 u_background;
out vec4 frag_color;
vec3 linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), vec3(greaterThan(c, vec3(0.04045)))); }
vec3 srgb(vec3 c) { return mix(12.92 * c, 1.055 * pow(max(c, 0.0), vec3(1.0 / 2.4)) - 0.055, vec3(greaterThan(c, vec3(0.0031308)))); }
void main() {
    vec2 uv = gl_FragCoord.xy / u_size;
    vec4 color = texture(u_color, uv);
    float depth = texture(u_depth, uv).r, visibility = texture(u_visibility, uv).r;
    if (uv.x < u_wipe && u_left == 1) visibility = 1.0;
    if (uv.x < u_wipe && u_left == 2) visibility = texture(u_truth, vec2(uv.x, 1.0 - uv.y)).r;
    bool nothing = depth >= 1.0;
    if (u_show == 1) {
        frag_color = vec4(vec3(visibility), 1.0);
    } else if (u_show == 2) {
        vec4 p = u_inverse * vec4(0.0, 0.0, 2.0 * depth - 1.0, 1.0);
        frag_color = vec4(vec3(nothing ? 0.0 : 1.0 - 0.9 * clamp((-p.z / p.w - u_range.x) / (u_range.y - u_range.x), 0.0, 1.0)), 1.0);
    } else if (u_show == 3) {
        frag_color = vec4(nothing ? vec3(0.0) : 0.5 + 0.5 * texture(u_normal, uv).xyz, 1.0);
    } else {
        float light = u_ambient * mix(1.0, visibility, u_strength) + (1.0 - u_ambient) * color.a;
        frag_color = vec4(nothing ? u_background : srgb(linear(color.rgb) * light), 1.0);
    }
}`];

function program(gl, [vertex, fragment]) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
        gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
        const { name } = gl.getActiveUniform(made, i);
        at[name] = gl.getUniformLocation(made, name);
    }
    return { made, at };
}

// The packed scene: a line of JSON, and the arrays behind it.
function parsed(bytes) {
    const end = bytes.indexOf(10), head = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    const data = bytes.slice(end + 1).buffer;
    const array = (place) => place && new ARRAYS[place.type](data, place.at, place.length);
    for (const part of [...head.meshes, ...head.spheres]) {
        for (const name of ["positions", "triangles", "places", "normals", "colors", "balls"]) part[name] = array(part[name]);
    }
    return head;
}

// The geometry in a WebGL2 context, and the targets that it is drawn into.
class SceneBuffers {
    constructor(gl, scene) {
        this.gl = gl;
        this.scene = scene;
        this.programs = { meshes: program(gl, MESH), spheres: program(gl, SPHERES) };
        this.parts = [...scene.meshes.map((part) => this.upload(part, "meshes")), ...scene.spheres.map((part) => this.upload(part, "spheres"))];
    }

    upload(part, kind) {
        const gl = this.gl, vao = gl.createVertexArray(), ball = kind === "spheres";
        gl.bindVertexArray(vao);
        const attribute = (location, array, size, type, normalized) => {
            if (!array) return;
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
            gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
            gl.enableVertexAttribArray(location);
            gl.vertexAttribPointer(location, size, type, normalized, location === 1 ? 4 : 0, 0);
            if (ball) gl.vertexAttribDivisor(location, 1);
        };
        attribute(0, part.positions ?? part.balls, ball ? 4 : 3, gl.FLOAT, false);
        attribute(1, part.normals, 3, gl.BYTE, true);
        attribute(2, part.colors, 4, gl.UNSIGNED_BYTE, true);
        if (part.triangles) {
            gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
            gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, part.triangles, gl.STATIC_DRAW);
        }
        const places = Array.from({ length: part.places.length / 16 }, (_, i) => part.places.subarray(16 * i, 16 * i + 16));
        const index = part.triangles?.BYTES_PER_ELEMENT === 2 ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
        return { vao, kind, places, index, count: part.triangles?.length ?? part.balls.length / 4, color: part.color };
    }

    resize(width, height) {
        const gl = this.gl;
        for (const texture of Object.values(this.textures ?? {})) gl.deleteTexture(texture);
        gl.deleteFramebuffer(this.framebuffer ?? null);
        const texture = (format) => {
            const made = gl.createTexture();
            gl.bindTexture(gl.TEXTURE_2D, made);
            gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
            for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, way, gl.NEAREST);
            return made;
        };
        this.textures = { color: texture(gl.RGBA8), normals: texture(gl.RGBA16F), depth: texture(gl.DEPTH_COMPONENT32F) };
        this.framebuffer = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
        const { color, normals, depth } = this.textures;
        [color, normals].forEach((one, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, one, 0));
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
        gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
        this.size = [width, height];
    }

    draw(view, projection) {
        const gl = this.gl;
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
        gl.viewport(0, 0, ...this.size);
        gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 1]);
        gl.clearBufferfv(gl.COLOR, 1, [0, 0, 0, 0]);
        gl.clearBufferfv(gl.DEPTH, 0, [1]);
        gl.enable(gl.DEPTH_TEST);
        gl.vertexAttrib4f(1, 0, 0, 0, 0); // of parts without normals or colours
        gl.vertexAttrib4f(2, 1, 1, 1, 1);
        for (const { vao, kind, places, index, count, color } of this.parts) {
            const { made, at } = this.programs[kind];
            gl.useProgram(made);
            gl.uniformMatrix4fv(at.u_view, false, view);
            gl.uniformMatrix4fv(at.u_projection, false, projection);
            gl.uniform3fv(at.u_color, color);
            gl.bindVertexArray(vao);
            for (const place of places) {
                gl.uniformMatrix4fv(at.u_place, false, place);
                if (kind === "meshes") gl.drawElements(gl.TRIANGLES, count, index, 0);
                else gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
            }
        }
        gl.disable(gl.DEPTH_TEST);
        gl.bindVertexArray(null);
    }
}

// What looks at the scene: one of its cameras, until it is moved.
class Eye {
    constructor(scene) {
        this.scene = scene;
        this.up = unit(scene.up);
        this.reach = Math.hypot(...scene.half) || 1;
        this.take(0);
    }

    take(index) {
        this.index = clamp(index, 0, this.scene.cameras.length - 1);
        this.camera = this.scene.cameras[this.index];
        this.pose = [...this.camera.pose];
        this.lens = { yfov: this.camera.yfov, height: this.camera.height, matrix: this.camera.matrix };
        this.moved = false;
        // Turns go about the point before the camera that is nearest to the middle of the scene.
        const z = column(this.pose, 2), at = column(this.pose, 3);
        this.target = sum(at, z, -Math.max(dot(at, z), 0.05 * this.reach));
    }

    place(newPose) {
        this.pose = [...newPose];
        this.moved = true;
    }

    turn(yaw, pitch) {
        const offset = sum(column(this.pose, 3), this.target, -1), length = Math.hypot(...offset);
        const side = unit(cross(this.up, [0, 0, 1].map((v, i) => (Math.abs(this.up[2]) < 0.9 ? v : [0, -1, 0][i]))));
        const front = cross(side, this.up), d = offset.map((v) => v / length);
        const elevation = clamp(Math.asin(clamp(dot(d, this.up), -1, 1)) + pitch, -1.55, 1.55);
        const azimuth = Math.atan2(dot(d, side), dot(d, front)) + yaw;
        const level = sum(front.map((v) => v * Math.cos(azimuth)), side, Math.sin(azimuth));
        const direction = sum(level.map((v) => v * Math.cos(elevation)), this.up, Math.sin(elevation));
        this.look(direction, length);
    }

    look(direction, length) {
        const z = unit(direction), x = unit(cross(this.up, z)), y = cross(z, x);
        this.place(pose(x, y, z, sum(this.target, z, length)));
    }

    move(right, up) { // shares of the image's height
        const length = Math.hypot(...sum(column(this.pose, 3), this.target, -1));
        const step = this.lens.height ?? 2 * length * Math.tan((this.lens.yfov ?? 1) / 2);
        const by = sum(column(this.pose, 0).map((v) => v * -right * step), column(this.pose, 1), -up * step);
        this.target = sum(this.target, by);
        this.place([...this.pose.slice(0, 12), ...sum(column(this.pose, 3), by), 1]);
    }

    nearer(factor) {
        if (this.lens.height) this.lens.height *= factor;
        const offset = sum(column(this.pose, 3), this.target, -1);
        this.place([...this.pose.slice(0, 12), ...sum(this.target, offset, factor), 1]);
    }

    // Clip planes around the scene's box; nothing before the eye is cut off.
    range() {
        const z = column(this.pose, 2), depth = dot(column(this.pose, 3), z);
        const reach = z.reduce((s, v, i) => s + Math.abs(v) * this.scene.half[i], 0) * 1.001 + 1e-6 * Math.abs(depth);
        const parallel = this.lens.height || (this.lens.matrix && this.lens.matrix[11] === 0);
        const far = Math.max(depth + reach, 1e-3 * this.reach);
        return [parallel ? depth - reach : Math.max(depth - reach, 1e-4 * far), far];
    }
}

const SHOWN = ["picture", "visibility", "depth", "normals"];

export class Viewer {
    // element: is filled. bytes: the scene. options: { size, looks, radius, ambient, truths }, as the page writes them.
    constructor(element, bytes, options) {
        this.options = options;
        this.scene = parsed(bytes);
        this.eye = new Eye(this.scene);
        this.state = { look: Object.keys(options.looks)[0], show: "picture", occlusion: true, compare: "nothing", wipe: 0.5, strength: 1, radius: options.radius, settings: {} };
        this.heard = [];
        this.build(element);
        const gl = (this.gl = this.canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true }));
        if (!gl) throw new Error("this browser has no WebGL2");
        if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("this browser cannot draw into float textures (EXT_color_buffer_float)");
        this.make();
        this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
        this.canvas.addEventListener("webglcontextrestored", () => { this.make(); this.fit(); });
        this.watch = new ResizeObserver(() => this.fit());
        this.watch.observe(element);
        this.listen();
        this.takeCamera(0);
        this.fit();
    }

    make() {
        this.buffers = new SceneBuffers(this.gl, this.scene);
        this.picture = program(this.gl, PICTURE);
        this.passes = {};
        this.truths = {};
    }

    // The canvas has the shape of the pictures by the cameras, and as many pixels as the screen shows of it, up to twice their number.
    fit() {
        const { root, stage, canvas, options, gl } = this, [w, h] = options.size, box = root.getBoundingClientRect();
        const scale = Math.min(box.width / w, box.height / h) || 1;
        stage.style.width = `${w * scale}px`;
        stage.style.height = `${h * scale}px`;
        const dense = Math.min(scale * (globalThis.devicePixelRatio || 1), 2);
        const size = [w, h].map((side) => Math.max(Math.round(side * dense), 1));
        if (canvas.width !== size[0] || canvas.height !== size[1] || !this.buffers.size) {
            [canvas.width, canvas.height] = size;
            this.buffers.resize(...size);
            for (const pass of Object.values(this.passes)) pass.resize(...size);
        }
        this.changed();
    }

    get radius() {
        return this.state.radius ?? this.eye.camera.radius ?? this.scene.radius;
    }

    changed() {
        this.pending ??= requestAnimationFrame(() => {
            this.pending = null;
            if (!this.closed) this.draw();
        });
    }

    pass() {
        const { look } = this.state, pipeline = this.options.looks[look];
        if (!this.passes[look]) {
            this.passes[look] = new SsaoGl(this.gl, pipeline);
            this.passes[look].resize(...this.buffers.size);
        }
        const values = {}, { live } = pipeline;
        for (const name in live) values[name] = this.state.settings[name] ?? live[name].value;
        if (live.radius && this.inUnits()) values.radius = this.radius;
        this.passes[look].set(values);
        return this.passes[look];
    }

    // Whether the radius of a look is in scene units, and no share of the image.
    inUnits() {
        return this.options.looks[this.state.look].live.radius?.high === undefined;
    }

    draw() {
        const { gl, state, eye, canvas, buffers, scene } = this;
        if (gl.isContextLost()) return;
        const started = performance.now();
        const range = eye.range(), projection = projectionOf(eye.lens, canvas.width / canvas.height, ...range);
        buffers.draw(viewOf(eye.pose), projection);
        const { color, depth, normals } = buffers.textures;
        let visibility = null;
        try {
            if (state.occlusion) visibility = this.pass().apply({ depth, normals, projection });
            this.say("");
        } catch (error) {
            this.say(error.message);
        }
        this.composite({ color, depth, normals, visibility }, projection, range, scene.background);
        this.frames = (this.frames ?? 0) + 1;
        this.milliseconds = performance.now() - started;
        this.onchange?.();
    }

    composite({ color, depth, normals, visibility }, projection, range, background) {
        const { gl, state, canvas } = this, { made, at } = this.picture, truth = this.truthTexture();
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.useProgram(made);
        const textures = { u_color: color, u_depth: depth, u_normal: normals, u_visibility: visibility ?? this.white(), u_truth: truth ?? this.white() };
        Object.entries(textures).forEach(([name, texture], unit) => {
            gl.activeTexture(gl.TEXTURE0 + unit);
            gl.bindTexture(gl.TEXTURE_2D, texture);
            gl.uniform1i(at[name], unit);
        });
        const left = state.compare === "no occlusion" ? 1 : state.compare === "rays" && truth ? 2 : 0;
        gl.uniform1i(at.u_show, SHOWN.indexOf(state.show));
        gl.uniform1i(at.u_left, left);
        gl.uniform1f(at.u_wipe, state.wipe);
        gl.uniform1f(at.u_ambient, this.options.ambient);
        gl.uniform1f(at.u_strength, state.strength);
        gl.uniform2f(at.u_size, canvas.width, canvas.height);
        gl.uniform2f(at.u_range, ...range);
        gl.uniformMatrix4fv(at.u_inverse, false, inverseDepth(projection));
        gl.uniform3fv(at.u_background, background?.slice(0, 3) ?? [0.66, 0.7, 0.75]);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        this.edge.hidden = !left;
        this.edge.style.left = `${100 * state.wipe}%`;
        this.edge.firstChild.textContent = state.compare;
        this.edge.lastChild.textContent = state.occlusion ? state.look : "no occlusion";
    }

    white() {
        const { gl } = this;
        if (!this.opened || this.opened.gl !== this.buffers) {
            this.opened = { gl: this.buffers, texture: gl.createTexture() };
            gl.bindTexture(gl.TEXTURE_2D, this.opened.texture);
            gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, 1, 1, 0, gl.RED, gl.UNSIGNED_BYTE, new Uint8Array([255]));
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        }
        return this.opened.texture;
    }

    // Rays of the camera, where the view is its own; null while the picture of them is read.
    truthTexture() {
        const { gl } = this, found = this.options.truths[this.eye.camera.name];
        if (!found || this.eye.moved) return null;
        const name = this.eye.camera.name;
        if (this.truths[name] === undefined) {
            this.truths[name] = null;
            const image = new Image();
            image.onload = () => {
                const texture = gl.createTexture();
                gl.bindTexture(gl.TEXTURE_2D, texture);
                gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
                for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
                for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, way, gl.LINEAR);
                this.truths[name] = texture;
                this.changed();
            };
            image.src = found.picture;
        }
        return this.truths[name];
    }

    // The panel and the stage. All text goes in as text.
    build(element) {
        const make = (tag, parent, text = "", more = {}) => parent.appendChild(Object.assign(document.createElement(tag), { textContent: text }, more));
        this.root = make("div", element, "", { className: "ssao" });
        make("style", this.root, STYLE);
        this.stage = make("div", this.root, "", { className: "stage" });
        this.canvas = make("canvas", this.stage, "", { tabIndex: 0 });
        this.canvas.setAttribute("aria-label", `${this.scene.name}: drag to turn, wheel to come nearer; keys are listed in the panel`);
        this.edge = make("div", this.stage, "", { className: "edge", hidden: true });
        make("span", this.edge);
        make("span", this.edge);
        const panel = (this.panel = make("details", this.root, "", { className: "panel", open: true }));
        make("summary", panel, this.scene.name || "scene");
        make("div", panel, this.scene.contents, { className: "note" });
        const field = (text, control) => {
            const label = make("label", panel), line = make("span", label, text);
            const value = make("output", line);
            label.append(control);
            return { label, value, control };
        };
        const select = (text, names, chosen, change) => {
            const control = document.createElement("select");
            control.name = text;
            for (const name of names) make("option", control, name, { value: name });
            control.value = chosen;
            control.addEventListener("change", () => change(control.value));
            return field(text, control);
        };
        const { state, options } = this;
        const names = this.scene.cameras.map(({ name }, i) => `${i + 1} ${name}`);
        this.fields = {
            camera: select("camera", names, names[0], (value) => this.takeCamera(names.indexOf(value))),
            show: select("show", SHOWN, state.show, (value) => this.set({ show: value })),
            look: select("method and preset", Object.keys(options.looks), state.look, (value) => this.set({ look: value })),
            compare: select("left of the wipe", ["nothing", "no occlusion", ...(Object.keys(options.truths).length ? ["rays"] : [])], state.compare, (value) => this.set({ compare: value })),
        };
        this.sliders = make("div", panel);
        this.note = make("div", panel, "", { className: "note", role: "status" });
        const help = make("details", panel);
        make("summary", help, "keys");
        const list = make("dl", help);
        for (const [key, what] of KEYS) { make("dt", list, key); make("dd", list, what); }
    }

    // Sliders for what the look can change: radii by powers of two about the scene's own, the rest linearly.
    makeSliders() {
        const { live } = this.options.looks[this.state.look], own = this.radius;
        this.sliders.replaceChildren();
        const slider = (name, value, low, high, told, change) => {
            const label = this.sliders.appendChild(document.createElement("label")), line = label.appendChild(document.createElement("span"));
            line.textContent = name;
            const output = line.appendChild(document.createElement("output"));
            const input = label.appendChild(Object.assign(document.createElement("input"), { type: "range", name, min: low, max: high, step: "any", value }));
            const tell = () => { output.textContent = told(+input.value); };
            input.addEventListener("input", () => { change(+input.value); tell(); });
            tell();
        };
        const short = (v) => `${+v.toPrecision(3)}`;
        if (live.radius && this.inUnits()) slider("radius", 0, -4, 4, (v) => short(own * 2 ** v), (v) => this.set({ radius: own * 2 ** v }));
        slider("strength", this.state.strength, 0, 1, short, (v) => this.set({ strength: v }));
        for (const name in live) {
            if (name === "radius" && this.inUnits()) continue;
            const { value, low = 0, high = Infinity, above } = live[name], now = this.state.settings[name] ?? value;
            if (Array.isArray(value)) continue;
            const top = Math.min(high, Math.max(4 * value, 0.1));
            slider(name, now, above === undefined ? low : Math.max(above, top / 100), top, short, (v) => this.set({ settings: { ...this.state.settings, [name]: v } }));
        }
    }

    say(text) {
        const rays = this.options.truths[this.eye.camera.name], compare = this.state.compare === "rays" && !text;
        this.note.textContent = text || (compare && this.eye.moved ? "rays: choose a camera; they are not traced for other views" : compare && rays ? `${rays.rays} rays a pixel, radius ${+rays.radius.toPrecision(3)}` : "");
    }

    // Change part of the state; what depends on it follows.
    set(state) {
        const look = this.state.look;
        Object.assign(this.state, state);
        for (const name of ["show", "look", "compare"]) this.fields[name].control.value = this.state[name];
        if (state.look !== undefined && state.look !== look) {
            this.state.settings = {};
            this.makeSliders();
        }
        this.changed();
    }

    takeCamera(index) {
        this.eye.take(index);
        this.fields.camera.control.selectedIndex = this.eye.index;
        this.makeSliders();
        this.changed();
    }

    // Show settings of another program: { look, show, radius, pose, ... }; a pose is camera to world about the scene's middle.
    show({ pose: newPose, looks, ...state }) {
        if (looks) {
            for (const name in looks) { this.passes[name]?.dispose(); delete this.passes[name]; }
            Object.assign(this.options.looks, looks);
        }
        if (newPose) this.eye.place(newPose);
        this.set(state);
        if (state.radius !== undefined) this.makeSliders();
    }

    on(target, name, listener, options) {
        target.addEventListener(name, listener, options);
        this.heard.push(() => target.removeEventListener(name, listener, options));
    }

    listen() {
        const { stage, canvas, edge } = this, pointers = new Map();
        const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a.x - b.x, a.y - b.y) || 1; };
        this.on(canvas, "contextmenu", (event) => event.preventDefault());
        this.on(canvas, "pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            canvas.focus({ preventScroll: true });
            pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, moves: event.button > 0 || event.shiftKey });
        });
        this.on(canvas, "pointermove", (event) => {
            const last = pointers.get(event.pointerId);
            if (!last) return;
            const height = stage.clientHeight || 1, dx = (event.clientX - last.x) / height, dy = (event.clientY - last.y) / height;
            const before = pointers.size === 2 && spread();
            Object.assign(last, { x: event.clientX, y: event.clientY });
            if (before) {
                this.eye.nearer(before / spread());
                this.eye.move(dx / 2, -dy / 2);
            } else if (pointers.size === 1 && last.moves) this.eye.move(dx, -dy);
            else if (pointers.size === 1) this.eye.turn(-4 * dx, 4 * dy);
            this.changed();
        });
        for (const name of ["pointerup", "pointercancel"]) this.on(canvas, name, (event) => pointers.delete(event.pointerId));
        this.on(canvas, "wheel", (event) => {
            event.preventDefault();
            this.eye.nearer(Math.exp(clamp(event.deltaY * (event.deltaMode ? 30 : 1), -300, 300) / 600));
            this.changed();
        }, { passive: false });
        this.on(edge, "pointerdown", (event) => edge.setPointerCapture(event.pointerId));
        this.on(edge, "pointermove", (event) => {
            if (!edge.hasPointerCapture(event.pointerId)) return;
            const box = stage.getBoundingClientRect();
            this.set({ wipe: clamp((event.clientX - box.left) / box.width, 0, 1) });
        });
        this.on(canvas, "keydown", (event) => this.key(event));
    }

    key(event) {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const { state, eye, options } = this, next = (list, now) => list[(list.indexOf(now) + 1) % list.length];
        const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
        const compared = [...this.fields.compare.control.options].map(({ value }) => value);
        const actions = {
            "+": () => eye.nearer(0.9), "=": () => eye.nearer(0.9), "-": () => eye.nearer(1 / 0.9),
            Home: () => this.takeCamera(eye.index),
            v: () => this.set({ show: next(SHOWN, state.show) }),
            o: () => this.set({ occlusion: !state.occlusion }),
            c: () => this.set({ compare: next(compared, state.compare) }),
            "[": () => this.set({ wipe: clamp(state.wipe - 0.05, 0, 1) }), "]": () => this.set({ wipe: clamp(state.wipe + 0.05, 0, 1) }),
            h: () => { this.panel.hidden = !this.panel.hidden; },
        };
        if (arrows) event.shiftKey ? eye.move(-0.05 * arrows[0], -0.05 * arrows[1]) : eye.turn(0.1 * arrows[0], 0.1 * arrows[1]);
        else if (/^[1-9]$/.test(event.key)) this.takeCamera(+event.key - 1);
        else if (actions[event.key]) actions[event.key]();
        else return;
        event.preventDefault();
        this.changed();
    }

    dispose() {
        this.closed = true;
        this.watch.disconnect();
        for (const stop of this.heard) stop();
        for (const pass of Object.values(this.passes)) pass.dispose();
        this.gl.getExtension("WEBGL_lose_context")?.loseContext();
        this.root.remove();
    }
}

// From window depth in the middle of the image to z and w of view space; the rest of the inverse is not asked for.
function inverseDepth(m) {
    // [z w] = [[m10 m14] [m11 m15]] [view z, 1]
    const det = m[10] * m[15] - m[14] * m[11];
    return [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, m[15] / det, -m[11] / det, 0, 0, -m[14] / det, m[10] / det];
}
