// Ambient occlusion as a pass of three.js's EffectComposer, where a RenderPass would stand. Needs three 0.180 or newer.
// The occlusion multiplies linear light, so tone mapping and sRGB (OutputPass) come after it.
import { Color, DepthTexture, ExternalTexture, FloatType, HalfFloatType, NoBlending, ShaderMaterial, WebGLRenderTarget } from "three";
import { FullScreenQuad, Pass } from "three/addons/postprocessing/Pass.js";
import defaultPipeline from "./pipeline.js";
import { SsaoGl } from "./ssao-gl.js";

const VERTEX = `varying vec2 v_uv;
void main() { v_uv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;
const FRAGMENT = `varying vec2 v_uv;
uniform sampler2D beauty, visibility;
uniform float intensity, shown;
uniform vec3 tint;
void main() {
    vec4 color = texture2D(beauty, v_uv);
    float open = mix(1.0, texture2D(visibility, v_uv).r, intensity);
    gl_FragColor = shown > 0.5 ? vec4(vec3(open), 1.0) : vec4(color.rgb * mix(tint, vec3(1.0), open), color.a);
}`;
const MODES = { Combined: 0, AO: 1 };

export class SsaoGlPass extends Pass {
    // pipeline: what `ssao-gl export --target three` wrote, without colour.
    constructor(scene, camera, width = 512, height = 512, pipeline = defaultPipeline) {
        super();
        if (pipeline.inputs.color || pipeline.inputs.normals || pipeline.inputs.depth.kind !== "window") {
            throw new Error("SsaoGlPass: expected a pipeline of window depth alone: ssao-gl export --target three");
        }
        Object.assign(this, { scene, camera, pipeline });
        const live = Object.fromEntries(Object.entries(pipeline.live).map(([name, { value }]) => [name, value]));
        // aoRadius: scene units. intensity: 0 to 1. color: of what is occluded. renderMode: "Combined" or "AO". The rest as in pipeline.live.
        this.configuration = { ...live, aoRadius: live.radius, intensity: 1, color: new Color(0, 0, 0), renderMode: "Combined" };
        delete this.configuration.radius;
        this.beauty = new WebGLRenderTarget(width, height, { type: HalfFloatType, depthTexture: new DepthTexture(width, height, FloatType) });
        this.visibility = new ExternalTexture(null);
        this.material = new ShaderMaterial({
            vertexShader: VERTEX, fragmentShader: FRAGMENT, blending: NoBlending, depthTest: false, depthWrite: false,
            uniforms: Object.fromEntries(["beauty", "visibility", "intensity", "shown", "tint"].map((name) => [name, { value: null }])),
        });
        this.quad = new FullScreenQuad(this.material);
    }

    setDisplayMode(mode) {
        this.configuration.renderMode = mode;
    }

    setSize(width, height) {
        this.beauty.setSize(width, height);
    }

    render(renderer, writeBuffer) {
        const { beauty, camera, configuration, material, pipeline } = this;
        if (renderer.capabilities.logarithmicDepthBuffer) throw new Error("SsaoGlPass: logarithmic depth is not read; use reversedDepthBuffer");
        renderer.setRenderTarget(beauty);
        renderer.render(this.scene, camera);
        const gl = renderer.getContext();
        if (this.effect?.gl !== gl) {
            this.effect?.ssao.dispose();
            this.effect = { gl, ssao: new SsaoGl(gl, pipeline) };
        }
        const { ssao } = this.effect, { aoRadius, intensity, color, renderMode, ...others } = configuration;
        const wanted = { ...others, ...(aoRadius !== undefined && { radius: aoRadius }) }, key = JSON.stringify(wanted);
        if (key !== this.effect.key) {
            ssao.set(wanted);
            this.effect.key = key;
        }
        ssao.resize(beauty.width, beauty.height);
        const depth = renderer.properties.get(beauty.depthTexture).__webglTexture;
        // With a reversed depth buffer three's projections map to 0..1.
        const clip = camera.reversedDepth ? "0..1" : "-1..1";
        const found = ssao.apply({ depth, projection: camera.projectionMatrix.elements, clip });
        if (found) this.visibility.sourceTexture = found;
        if (!(renderMode in MODES)) throw new Error(`SsaoGlPass: renderMode '${renderMode}': must be one of ${Object.keys(MODES)}`);
        const values = { beauty: beauty.texture, visibility: this.visibility, intensity, shown: MODES[renderMode], tint: color };
        for (const name in values) material.uniforms[name].value = values[name];
        renderer.setRenderTarget(this.renderToScreen ? null : writeBuffer);
        this.quad.render(renderer);
    }

    dispose() {
        this.effect?.ssao.dispose();
        this.beauty.depthTexture.dispose();
        this.beauty.dispose();
        this.material.dispose();
        this.quad.dispose();
    }
}
