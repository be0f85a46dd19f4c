import type { Camera, Color, Scene } from "three";
import { Pass } from "three/addons/postprocessing/Pass.js";
import type { Pipeline } from "./ssao-gl.js";

/** Draws the scene with ambient occlusion; stands where a RenderPass would. Tone mapping and sRGB (OutputPass) come after it. */
export class SsaoGlPass extends Pass {
    /** Without a pipeline the one beside this module is taken. Throws for one that needs colour, normals or eye depth. */
    constructor(scene: Scene, camera: Camera, width?: number, height?: number, pipeline?: Pipeline);
    scene: Scene;
    camera: Camera;
    /** May change between frames; the rest are the pipeline's live settings. */
    configuration: {
        /** Reach of occlusion, scene units. */
        aoRadius: number;
        /** 0 leaves the colour, 1 dims it by all of the occlusion. */
        intensity: number;
        /** Of what is occluded, linear light. */
        color: Color;
        renderMode: "Combined" | "AO";
        [setting: string]: unknown;
    };
    setDisplayMode(mode: "Combined" | "AO"): void;
}
