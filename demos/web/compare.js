// Every pass on the same scene, camera and renderer: visibility against rays, and what a frame takes longer than without it.
import { N8AOPass } from "n8ao";
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { EffectComposer } from "three/addons/postprocessing/EffectComposer.js";
import { GTAOPass } from "three/addons/postprocessing/GTAOPass.js";
import { RenderPass } from "three/addons/postprocessing/RenderPass.js";
import { SSAOPass } from "three/addons/postprocessing/SSAOPass.js";

const n8ao = (quality, halfRes, neural = false) => ({ scene, camera, size, radius }) => {
    const pass = new N8AOPass(scene, camera, ...size);
    pass.setQualityMode(quality);
    Object.assign(pass.configuration, { aoRadius: radius, intensity: 1, halfRes, gammaCorrection: false });
    if (neural) pass.configuration.neuralDenoise = true;
    pass.setDisplayMode("AO");
    return [pass];
};

// As shipped, but for the radius, and an intensity of 1 where there is one.
const PASSES = {
    "N8AO Performance, half size": n8ao("Performance", true),
    "N8AO Medium": n8ao("Medium", false),
    "N8AO Low, half size, neural": n8ao("Low", true, true),
    "three SSAOPass": ({ scene, camera, size, radius }) => {
        const pass = new SSAOPass(scene, camera, ...size);
        pass.kernelRadius = radius;
        pass.output = SSAOPass.OUTPUT.Blur;
        return [new RenderPass(scene, camera), pass];
    },
    "three GTAOPass": ({ scene, camera, size, radius }) => {
        const pass = new GTAOPass(scene, camera, ...size);
        pass.updateGtaoMaterial({ radius });
        pass.output = GTAOPass.OUTPUT.Denoise;
        return [new RenderPass(scene, camera), pass];
    },
};

async function ours(presets) {
    const { SsaoGlPass } = await import("./data/three/ssao-gl-three.js");
    return Object.fromEntries(await Promise.all(presets.map(async (preset) => {
        const { default: pipeline } = await import(`./data/${preset}/pipeline.js`);
        return [`ssao_gl ${preset}`, ({ scene, camera, size, radius }) => {
            const pass = new SsaoGlPass(scene, camera, ...size, pipeline);
            Object.assign(pass.configuration, { aoRadius: radius, renderMode: "AO" });
            return [pass];
        }];
    })));
}

const json = async (url) => (await fetch(url)).json();
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

function cameraOf(view, [width, height], reach) {
    const camera = new THREE.PerspectiveCamera(view.yfov_deg, width / height, view.znear, Math.min(view.zfar, reach));
    camera.position.set(...view.eye);
    camera.up.set(...view.up);
    camera.lookAt(...view.target);
    camera.updateMatrixWorld();
    return camera;
}

// Composer of passes that ends in 8 bits, whose red channel is visibility.
function composer(renderer, passes, [width, height]) {
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.HalfFloatType });
    const made = new EffectComposer(renderer, target);
    made.renderToScreen = false;
    made.setPixelRatio(1);
    for (const pass of passes) made.addPass(pass);
    return made;
}

// Draw and wait: reading one pixel back ends when all is drawn.
function frame(renderer, made) {
    made.render();
    const pixel = new Uint16Array(4);
    renderer.readRenderTargetPixels(made.readBuffer, 0, 0, 1, 1, pixel);
}

function visibilityOf(renderer, made, [width, height]) {
    frame(renderer, made);
    const pixels = new Uint16Array(4 * width * height);
    renderer.readRenderTargetPixels(made.readBuffer, 0, 0, width, height, pixels);
    return Float32Array.from({ length: width * height }, (_, i) => THREE.DataUtils.fromHalfFloat(pixels[4 * i]));
}

function show(parent, name, values, [width, height], caption) {
    const figure = parent.appendChild(document.createElement("figure"));
    const canvas = figure.appendChild(Object.assign(document.createElement("canvas"), { width, height }));
    const image = new ImageData(width, height);
    values.forEach((value, i) => { // row 0 at the bottom
        const at = 4 * ((height - 1 - Math.floor(i / width)) * width + (i % width));
        image.data.set([255 * value, 255 * value, 255 * value, 255], at);
    });
    canvas.getContext("2d").putImageData(image, 0, 0);
    figure.appendChild(document.createElement("figcaption")).textContent = `${name}: ${caption}`;
}

function plain(scene) { // as the rays see it: every triangle, from both sides
    const material = new THREE.MeshBasicMaterial({ color: 0xffffff, side: THREE.DoubleSide });
    scene.traverse((object) => { if (object.isMesh) object.material = material; });
}

export async function compare(parent, say) {
    const job = await json("./data/job.json"), { size, rounds } = job, results = { renderer: "", views: [] };
    const passes = { ...(await ours(job.presets)), ...PASSES };
    const renderer = new THREE.WebGLRenderer({ antialias: false });
    renderer.setSize(...size, false);
    const gl = renderer.getContext(), named = gl.getExtension("WEBGL_debug_renderer_info");
    results.renderer = gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    for (const view of job.views) {
        say(`${view.name} ...`);
        const { scene } = await new GLTFLoader().loadAsync(`./data/${view.scene}`);
        const world = new THREE.Scene().add(scene);
        plain(world);
        const camera = cameraOf(view, size, view.reach), given = { scene: world, camera, size, radius: view.ao_radius };
        const truth = new Float32Array(await (await fetch(`./data/${view.truth}`)).arrayBuffer()); // row 0 at the bottom, -1 background
        const errorOf = (values) => {
            let squares = 0, sum = 0, count = 0;
            truth.forEach((t, i) => { if (t >= 0) { squares += (values[i] - t) ** 2; sum += values[i] - t; count++; } });
            return { rmse: Math.sqrt(squares / count), bias: sum / count };
        };
        const all = { nothing: composer(renderer, [new RenderPass(world, camera)], size) }, measured = {}, times = {};
        for (const [name, make] of Object.entries(passes)) all[name] = composer(renderer, make(given), size);
        for (const [name, made] of Object.entries(all)) {
            // The first frames compile, and settle what a pass makes on its first.
            for (let i = 0; i < 2; i++) frame(renderer, made);
            const values = name === "nothing" ? truth.map((t) => Math.abs(t)) : visibilityOf(renderer, made, size);
            measured[name] = { ...errorOf(values), values };
            times[name] = [];
            await new Promise((done) => setTimeout(done));
        }
        for (let round = 0; round < rounds; round++) { // interleaved: a busy machine slows all alike
            for (const [name, made] of Object.entries(all)) {
                const started = performance.now();
                frame(renderer, made);
                times[name].push(performance.now() - started);
            }
            await new Promise((done) => setTimeout(done));
        }
        const rows = {};
        for (const name of Object.keys(passes)) {
            const ms = median(times[name].map((time, round) => time - times.nothing[round]));
            rows[name] = { rmse: measured[name].rmse, bias: measured[name].bias, ms };
        }
        const heading = parent.appendChild(document.createElement("h2"));
        heading.textContent = view.name;
        heading.style.gridColumn = "1 / -1";
        show(parent, "rays", measured.nothing.values, size, `${view.spp} a pixel`);
        for (const [name, { rmse, ms }] of Object.entries(rows)) show(parent, name, measured[name].values, size, `RMSE ${rmse.toFixed(4)}, ${ms.toFixed(1)} ms`);
        results.views.push({ name: view.name, nothing: median(times.nothing), rows });
        for (const made of Object.values(all)) { for (const pass of made.passes) pass.dispose?.(); made.dispose(); }
    }
    say(`${job.size.join(" x ")} pixels, ${results.renderer}; milliseconds beyond a frame without occlusion, medians of ${rounds} interleaved rounds.`);
    return results;
}
