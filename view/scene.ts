// SPDX-License-Identifier: Apache-2.0
// scene.ts - draws the model through three.js: one sample a pixel while things move, then four, averaged in linear
// light, as `sheen render` does. Where drawing is slow (no graphics processor) moving pictures are coarser.
import {
    BufferAttribute,
    BufferGeometry,
    Camera,
    CustomBlending,
    AddEquation,
    OneFactor,
    DataTexture,
    DoubleSide,
    FloatType,
    GLSL3,
    HalfFloatType,
    LinearFilter,
    Matrix3,
    Matrix4,
    Mesh,
    NearestFilter,
    NoBlending,
    RawShaderMaterial,
    RedFormat,
    RGBAFormat,
    RGFormat,
    Scene,
    SRGBColorSpace,
    Texture,
    UnsignedByteType,
    Vector2,
    Vector3,
    Vector4,
    WebGLRenderer,
    WebGLRenderTarget,
} from "three";
import { makeBvh } from "./bvh";
import { type Cells, makeCells } from "./cells";
import { lampTable } from "./lamps";
import { type Model, ModelError, mostSuns } from "./model";
import type { More } from "./more";
import { addShader, coverShader, encodeShader, fragmentShader, vertexShader } from "./shader";
import { poseOf, rotation, type View } from "./view";

const tableWidth = 1024;
const background = 0.03;
const offsets = [
    [-0.25, -0.25],
    [0.25, -0.25],
    [-0.25, 0.25],
    [0.25, 0.25],
]; // of a pixel's samples, right and down
const slow = 1 / 20; // s a frame
const fast = 1 / 50;
const patience = 120; // fast frames before a finer picture is tried again
const coarsest = 4;

function plain<T extends Texture>(texture: T): T {
    texture.magFilter = texture.minFilter = NearestFilter;
    texture.generateMipmaps = false;
    texture.flipY = false;
    texture.needsUpdate = true;
    return texture;
}

function rangeTexture(cells: Cells): DataTexture {
    const side = Math.max(1, cells.side);
    return plain(new DataTexture(cells.range, side, side, RGFormat, FloatType));
}

// A list of four numbers each, in rows of tableWidth; words are half floats.
function tableTexture(list: Float32Array | Uint16Array): DataTexture {
    const n = 4 * tableWidth * Math.max(1, Math.ceil(list.length / 4 / tableWidth));
    const isFloat = list instanceof Float32Array;
    const data = isFloat ? new Float32Array(n) : new Uint16Array(n);
    data.set(list);
    return plain(new DataTexture(data, tableWidth, n / 4 / tableWidth, RGBAFormat, isFloat ? FloatType : HalfFloatType));
}

const shadowless = 1e30;
const negligible = 2e-4; // as render/shade.c

// What the shader wants to know of shadows and surroundings.
function surroundingsUniforms(model: Model): RawShaderMaterial["uniforms"] {
    const around = model.surroundings;
    const light = model.irradiance;
    const bvh = model.shadows || around || light?.lamps.length ? makeBvh(model.position) : null;
    const board = around?.board;
    const picture = board ? plain(new Texture(board.picture)) : null;
    if (picture) {
        picture.colorSpace = SRGBColorSpace;
        picture.magFilter = picture.minFilter = LinearFilter; // sRGB is decoded before
    }
    return {
        nodes: { value: bvh && tableTexture(bvh.node) },
        triangles: { value: bvh && tableTexture(bvh.triangle) },
        nNodes: { value: bvh ? bvh.node.length / 8 : 0 },
        offset: { value: 2e-3 * model.radius },
        leastShadowed: { value: shadowless },
        mirrors: { value: around !== null },
        worldFromObj: { value: new Matrix3() },
        boardFromObj: { value: new Matrix3().set(...(rotation(model.worldFromObj).flat() as Parameters<Matrix3["set"]>)) },
        boardOrigin: { value: new Vector3(...model.worldFromObj.slice(3)) },
        ambient: { value: Array.from({ length: 9 }, (_, k) => new Vector3(...(around?.ambientRgb[k] ?? [0, 0, 0]))) },
        board: { value: picture },
        boardPlace: { value: board ? new Vector4(board.x0, board.y0, board.pitch, board.white) : new Vector4() },
        tableRgb: { value: new Vector3(...(around?.tableRgb ?? [0, 0, 0])) },
        f0: { value: around?.f0 ?? 0 },
        lit: { value: light !== null },
        irradiance: { value: Array.from({ length: 9 }, (_, k) => new Vector3(...(light?.harmonics[k] ?? [0, 0, 0]))) },
        nSuns: { value: light?.lamps.length ?? 0 },
        suns: { value: Array.from({ length: mostSuns }, (_, k) => new Vector4(...(light?.lamps[k]?.direction ?? [0, 0, 0]), light?.lamps[k]?.perMetre ?? 0)) },
        sunRgb: { value: Array.from({ length: mostSuns }, (_, k) => new Vector3(...(light?.lamps[k]?.rgb ?? [0, 0, 0]))) },
    };
}

function cover(fragment: string, uniforms: RawShaderMaterial["uniforms"]): { scene: Scene; material: RawShaderMaterial } {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const material = new RawShaderMaterial({
        glslVersion: GLSL3,
        vertexShader: coverShader,
        fragmentShader: fragment,
        uniforms,
        depthTest: false,
        depthWrite: false,
        blending: NoBlending,
    });
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    const scene = new Scene();
    scene.add(mesh);
    return { scene, material };
}

export class Stage {
    private readonly renderer: WebGLRenderer;
    private readonly camera = new Camera();
    private readonly object = new Scene();
    private readonly material: RawShaderMaterial;
    private readonly sample: WebGLRenderTarget;
    private readonly total: WebGLRenderTarget;
    private readonly add: ReturnType<typeof cover>;
    private readonly encode: ReturnType<typeof cover>;
    private cellsSigma = 0;
    private drawn: View | null = null; // what `total` holds samples of
    private nDrawn = 0;
    private coarseness = 1;
    private nFast = 0; // frames in a row

    constructor(
        private readonly canvas: HTMLCanvasElement,
        private readonly model: Model,
        private readonly more: More,
    ) {
        const context = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
        if (!context) throw new ModelError("This browser has no WebGL2, which this page draws with. Another browser, or one with graphics acceleration switched on, will show it.");
        if (!context.getExtension("EXT_color_buffer_float") && !context.getExtension("EXT_color_buffer_half_float"))
            throw new ModelError("This browser's graphics cannot draw into floating-point pictures, which this page needs.");
        const largest = context.getParameter(context.MAX_TEXTURE_SIZE) as number;
        if (Math.max(model.width, model.height, (model.normalMap?.offset.length ?? 0) / 4 / tableWidth) > largest)
            throw new ModelError(`The texture of this model, ${model.width} x ${model.height} px, is larger than this device can hold (${largest}).`);
        this.renderer = new WebGLRenderer({ canvas, context });
        this.renderer.autoClear = true;
        this.renderer.setClearColor(0, 0);

        const atlas = plain(new Texture(model.texture));
        atlas.colorSpace = SRGBColorSpace;
        const seen = plain(new DataTexture(model.seen, model.width, model.height, RedFormat, UnsignedByteType));
        seen.unpackAlignment = 1;
        this.material = new RawShaderMaterial({
            glslVersion: GLSL3,
            vertexShader,
            fragmentShader,
            side: DoubleSide,
            blending: NoBlending,
            uniforms: {
                clipFromObj: { value: new Matrix4() },
                atlas: { value: atlas },
                seen: { value: seen },
                cellRange: { value: null },
                lights: { value: null },
                texelsPerEdge: { value: model.texelsPerEdge },
                columns: { value: model.columns },
                side: { value: 0 },
                sigma: { value: model.sigma },
                specularRgb: { value: new Vector3() },
                cameraObj: { value: new Vector3() },
                holeRgb: { value: new Vector3() },
                filled: { value: model.filled },
                lightFromObj: { value: new Matrix3() },
                show: { value: new Vector2(1, 1) },
                wire: { value: false },
                offsets: { value: model.normalMap && tableTexture(model.normalMap.offset) },
                offsetsPerEdge: { value: model.normalMap?.texelsPerEdge ?? 0 },
                lamps: { value: null },
                nLamps: { value: model.lamps?.lights.length ?? 0 },
                lampOrigin: { value: new Vector3() },
                lampLobe: { value: new Vector3(model.lamps?.tail ?? 0, model.lamps?.fresnel ?? 0, 1) },
                nGloss: { value: model.gloss?.colours.length ?? 0 },
                glossWidth: { value: model.gloss?.width ?? 1 },
                gloss: { value: Array.from({ length: 32 }, (_, i) => new Vector4(...(model.gloss?.colours[i] ?? [0, 0, 0, 0]))) },
                ...surroundingsUniforms(model),
            },
        });
        const geometry = new BufferGeometry();
        geometry.setAttribute("position", new BufferAttribute(model.position, 3));
        geometry.setAttribute("normal", new BufferAttribute(model.normal, 3));
        const mesh = new Mesh(geometry, this.material);
        mesh.frustumCulled = false;
        this.object.add(mesh);

        const target = { type: HalfFloatType, format: RGBAFormat, minFilter: NearestFilter, magFilter: NearestFilter };
        this.sample = new WebGLRenderTarget(1, 1, target);
        this.total = new WebGLRenderTarget(1, 1, { ...target, depthBuffer: false });
        this.add = cover(addShader, { source: { value: this.sample.texture }, share: { value: 1 / offsets.length } });
        this.add.material.blending = CustomBlending;
        this.add.material.blendEquation = AddEquation;
        this.add.material.blendSrc = this.add.material.blendDst = OneFactor;
        this.add.material.blendSrcAlpha = this.add.material.blendDstAlpha = OneFactor;
        this.encode = cover(encodeShader, {
            source: { value: null },
            scale: { value: new Vector2(1, 1) },
            backgroundRgb: { value: new Vector3(background, background, background) },
        });
    }

    // Whether the browser has taken the graphics away; the renderer asks for them back, and fills them again.
    get lost(): boolean {
        return this.renderer.getContext().isContextLost();
    }

    // After that: what was drawn is gone, and so is the colour to clear with.
    restore(): void {
        this.renderer.setClearColor(0, 0);
        this.drawn = null;
    }

    // Size of the canvas in its own pixels; true where it has changed.
    resize(): boolean {
        const ratio = Math.min(window.devicePixelRatio || 1, 2);
        const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
        const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
        if (this.canvas.width === width && this.canvas.height === height && this.total.width === width && this.total.height === height)
            return false;
        this.renderer.setPixelRatio(1);
        this.renderer.setSize(width, height, false);
        this.total.setSize(width, height);
        this.drawn = null;
        return true;
    }

    private setLights(sigma: number): void {
        if (sigma === this.cellsSigma) return;
        const u = this.material.uniforms;
        const cells = makeCells(this.model.lightDirection, this.model.lightWeight, sigma);
        (u.cellRange.value as Texture | null)?.dispose();
        (u.lights.value as Texture | null)?.dispose();
        u.cellRange.value = rangeTexture(cells);
        u.lights.value = tableTexture(cells.entry);
        (u.lamps.value as Texture | null)?.dispose();
        u.lamps.value = tableTexture(lampTable(this.model.lamps, sigma));
        u.side.value = cells.side;
        u.sigma.value = sigma;
        this.cellsSigma = sigma;
    }

    private setView(view: View, width: number, height: number, offset: number[]): void {
        const u = this.material.uniforms;
        const { R, t, camera, worldFromObj, lightFromObj, lightOrigin } = poseOf(this.model, view, this.more.photographs[view.photo]?.rtCamObj);
        const [x, y, z] = this.model.centre;
        const depth = R[2][0] * x + R[2][1] * y + R[2][2] * z + t[2];
        const near = Math.max(depth - 1.01 * this.model.radius, 0.005 * this.model.radius);
        const far = Math.max(depth, 0) + 1.01 * this.model.radius;
        // A photograph is shown whole, with bars beside or above it.
        const share = view.photo >= 0 ? Math.min(1, (height * this.more.aspect) / width) : 1;
        const fx = 2 * this.model.focalPerWidth * share;
        const fy = (-fx * width) / height;
        // A sample right of and below the pixel's middle: the picture moves left and up.
        const cx = (-2 * offset[0]) / width;
        const cy = (2 * offset[1]) / height;
        const a = (far + near) / (far - near);
        const b = (-2 * far * near) / (far - near);
        const row = (f: number, c: number, i: number): number[] => [0, 1, 2].map((k) => f * R[i][k] + c * R[2][k]);
        (u.clipFromObj.value as Matrix4).set(
            ...(row(fx, cx, 0) as [number, number, number]), fx * t[0] + cx * t[2],
            ...(row(fy, cy, 1) as [number, number, number]), fy * t[1] + cy * t[2],
            ...(row(0, a, 2) as [number, number, number]), a * t[2] + b,
            ...(R[2] as [number, number, number]), t[2],
        );
        (u.cameraObj.value as Vector3).fromArray(camera);
        (u.lightFromObj.value as Matrix3).set(...(lightFromObj.flat() as Parameters<Matrix3["set"]>));
        (u.worldFromObj.value as Matrix3).set(...(worldFromObj.flat() as Parameters<Matrix3["set"]>));
        const from = this.model.lamps?.origin ?? [0, 0, 0];
        (u.lampOrigin.value as Vector3).fromArray(lightOrigin.map((x, k) => x - from[k]));
        (u.lampLobe.value as Vector3).z = view.strength;
        const kS = this.model.kS * view.strength;
        u.leastShadowed.value = this.model.shadows && kS > 0 ? negligible / kS : shadowless;
        (u.specularRgb.value as Vector3).fromArray(this.model.lightRgb).multiplyScalar(kS);
        (u.holeRgb.value as Vector3).set(view.holes ? 1 : 0, 0, view.holes ? 1 : 0);
        u.wire.value = view.wire;
        (u.show.value as Vector2).set(view.layer === "specular" ? 0 : 1, view.layer === "diffuse" ? 0 : 1);
        this.setLights(view.sigma);
    }

    private render(scene: Scene, to: WebGLRenderTarget | null, clear: boolean): void {
        this.renderer.setRenderTarget(to);
        this.renderer.autoClear = clear;
        this.renderer.render(scene, this.camera);
    }

    private present(from: WebGLRenderTarget): void {
        const u = this.encode.material.uniforms;
        u.source.value = from.texture;
        (u.scale.value as Vector2).set(from.width / this.canvas.width, from.height / this.canvas.height);
        this.render(this.encode.scene, null, true);
    }

    // While things move: one sample a pixel, or one for several where the last frame took long (seconds).
    drawMoving(view: View, lastFrame: number): void {
        this.nFast = lastFrame > 0 && lastFrame < fast ? this.nFast + 1 : 0;
        if (lastFrame > slow && this.coarseness < coarsest) this.coarseness *= 2;
        else if (this.nFast > patience && this.coarseness > 1) {
            this.coarseness /= 2;
            this.nFast = 0;
        }
        const width = Math.ceil(this.canvas.width / this.coarseness);
        const height = Math.ceil(this.canvas.height / this.coarseness);
        this.sample.setSize(width, height);
        this.setView(view, this.canvas.width, this.canvas.height, [0, 0]);
        this.render(this.object, this.sample, true);
        this.present(this.sample);
        this.drawn = null;
    }

    // When things stand still: one more of a pixel's samples; true when the picture is complete.
    drawStill(view: View): boolean {
        if (this.drawn !== view) {
            this.drawn = view;
            this.nDrawn = 0;
            this.renderer.setRenderTarget(this.total);
            this.renderer.clear();
        }
        if (this.nDrawn < offsets.length) {
            this.sample.setSize(this.canvas.width, this.canvas.height);
            this.setView(view, this.canvas.width, this.canvas.height, offsets[this.nDrawn]);
            this.render(this.object, this.sample, true);
            this.render(this.add.scene, this.total, false);
            this.nDrawn++;
        }
        if (this.nDrawn < offsets.length) return false;
        this.present(this.total);
        return true;
    }
}
