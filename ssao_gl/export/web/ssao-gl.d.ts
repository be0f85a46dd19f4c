/** What `ssao-gl export` wrote; pipeline.schema.json describes all of it. */
export interface Pipeline {
    format: "ssao_gl pipeline 1";
    live: Record<string, { value: number | number[]; above?: number; low?: number; high?: number }>;
    [part: string]: unknown;
}

/** Settings that change no shader, as far as the pipeline has them (`Object.keys(pipeline.live)`). */
export interface LiveSettings {
    /** Reach of occlusion, scene units (of `lecture`: a share of the image). */
    radius?: number;
    /** 0 leaves the colour, 1 dims it by all of the occlusion. */
    strength?: number;
    /** Contrast: visibility to this power. */
    power?: number;
    /** Linear light in 0..1 that is left where all is hidden: a THREE.Color's r, g and b. */
    tint?: [number, number, number];
    /** Of what a texel shows, behind it, radii. */
    thickness?: number;
    /** Distance off the tangent plane at which the filter still counts a tap in full, pixels. */
    tolerance?: number;
    [name: string]: number | number[] | undefined;
}

export interface ApplyInputs {
    /** Window depth (a depth texture, or its values in a red channel) or eye depth (R32F), as the pipeline was exported. */
    depth: WebGLTexture;
    /** sRGB values (RGBA8), where the pipeline was exported with colour. */
    color?: WebGLTexture;
    /** View-space normals, xyz in -1..1, where the pipeline was exported with normals. */
    normals?: WebGLTexture;
    /** 16 numbers, column by column: three.js's `camera.projectionMatrix.elements`, any projection. */
    projection: ArrayLike<number>;
    /** Depth range that the projection maps to; "0..1" with EXT_clip_control. Default "-1..1". */
    clip?: "-1..1" | "0..1";
    /** A framebuffer to draw the result into as well, at its lower left corner; null is the canvas. */
    target?: WebGLFramebuffer | null;
}

/**
 * Ambient occlusion over a depth texture. The caller's GL state is as it was after every call, also when it throws.
 * (Queries that count samples cannot be paused in WebGL2, and must not run.)
 */
export class SsaoGl {
    /** Throws an Error where `gl` is no WebGL2 context, or cannot draw into float textures. */
    constructor(gl: WebGL2RenderingContext, pipeline: Pipeline);
    /** The live settings as they are. */
    readonly settings: Record<string, number | number[]>;
    /** Change live settings. Throws for one that is fixed or out of range, and then changes none. */
    set(settings: LiveSettings): void;
    /** The size of your textures, pixels. */
    resize(width: number, height: number): void;
    /**
     * Draw. Returns the texture of the result, the runtime's own, valid until the next call: visibility in red (R8), or the
     * picture (RGBA8). Returns null while the context is lost; when it comes back, calls work again with new textures.
     */
    apply(inputs: ApplyInputs): WebGLTexture | null;
    /** Free every GL object. Calling it twice does no harm. */
    dispose(): void;
}
