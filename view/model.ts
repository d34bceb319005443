// SPDX-License-Identifier: Apache-2.0
// model.ts - the packed model of the page, read (docs/viewer.md is the format; render/page_unpack.c its other reader).

import { type NormalMap, readNormalMap } from "./normals";

export interface Model {
    nTriangles: number;
    position: Float32Array; // [nTriangles][3][3], frame of the object, metres
    normal: Float32Array;
    normalMap: NormalMap | null;
    texelsPerEdge: number;
    columns: number; // blocks in a row of the atlas
    width: number; // of the atlas, px
    height: number;
    filled: boolean; // texels that no photograph saw have a colour all the same
    seen: Uint8Array; // [height][width]: 255 where a photograph saw the texel
    texture: ImageBitmap;
    lightDirection: Float32Array; // [nLights][3], unit, frame of the lights ("world")
    lightWeight: Float32Array;
    objectMoves: boolean; // the lights stand still before the camera
    kS: number;
    sigma: number; // rad
    lightRgb: number[];
    shadows: boolean; // the mesh hides lights from its own surface
    lamps: Lamps | null;
    gloss: { width: number; colours: number[][] } | null; // how strongly each colour of texture shines (render/gloss.h)
    surroundings: Surroundings | null;
    irradiance: Irradiance | null; // where there is one, the texture is an albedo (render/irradiance.h)
    worldFromObj: number[]; // Rodrigues vector, translation; in the first photograph
    worldFromCam: number[]; // of lights that stand still before the camera
    boardFromObj: number[];
    focalPerWidth: number;
    centre: number[]; // of the object, in its frame
    radius: number;
}

// Lights with a place, an extent and a colour, and their lobe (render/lamp.h).
export interface Lamp {
    direction: number[]; // unit, from the lamps' origin, frame of the lights
    perMetre: number; // inverse distance
    radius: number; // rad
    rgb: number[];
}

export interface Lamps {
    origin: number[];
    tail: number;
    fresnel: number;
    lights: Lamp[];
}

// Light on the texture of an object that turned.
export interface Irradiance {
    harmonics: number[][]; // 9 of rgb
    lamps: { direction: number[]; rgb: number[]; perMetre: number }[]; // frame of the lights
}

// What is mirrored besides the lights (render/surroundings.h).
export interface Surroundings {
    f0: number;
    ambientRgb: number[][];
    tableRgb: number[];
    board: { picture: ImageBitmap; x0: number; y0: number; pitch: number; white: number } | null;
}

const magic = 0x324e4853;

export class ModelError extends Error {}

function damaged(): ModelError {
    return new ModelError("The model in this page is damaged. Was the page saved or sent incompletely?");
}

function fromBase64(id: string): Uint8Array<ArrayBuffer> {
    const text = document.getElementById(id)?.textContent ?? "";
    try {
        return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    } catch {
        throw damaged();
    }
}

// Limits far beyond any model that is exported: what passes them was made to fill memory, and is refused before it does.
const mostBytes = 256 * 1024 * 1024; // inflated
const mostNodes = 400 * 400 * 10; // of a hemisphere of the finest lattice (render/geodesic.h)
const mostLamps = 4096; // render/model.h
export const mostSuns = 24; // render/irradiance.h

// The whole stream, unless it holds more than mostBytes: deflate can hide a thousand times its size.
async function inflate(packed: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
    const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
    const pieces: Uint8Array[] = [];
    let size = 0;
    try {
        for (let piece = await reader.read(); !piece.done; piece = await reader.read()) {
            size += piece.value.length;
            if (size > mostBytes) throw damaged();
            pieces.push(piece.value);
        }
    } catch {
        throw damaged();
    }
    const whole = new Uint8Array(size);
    let at = 0;
    for (const piece of pieces) {
        whole.set(piece, at);
        at += piece.length;
    }
    return whole;
}

interface Vertices {
    position: Float32Array;
    normal: Float32Array;
}

// Five numbers of 16 bits a vertex, each in a plane of low and one of high bytes, as folded differences.
function readVertices(bytes: Uint8Array, n: number, low: number[], high: number[]): Vertices {
    const position = new Float32Array(3 * n);
    const normal = new Float32Array(3 * n);
    const code = [0, 0, 0, 0, 0];
    for (let i = 0; i < n; i++) {
        for (let k = 0; k < 5; k++) {
            const folded = bytes[2 * k * n + i] | (bytes[(2 * k + 1) * n + i] << 8);
            code[k] = (code[k] + ((folded >> 1) ^ (folded & 1 ? 0xffff : 0))) & 0xffff;
        }
        for (let k = 0; k < 3; k++) position[3 * i + k] = low[k] + ((high[k] - low[k]) * code[k]) / 65535;
        const u = (code[3] / 65535) * 2 - 1;
        const v = (code[4] / 65535) * 2 - 1;
        const z = 1 - Math.abs(u) - Math.abs(v);
        const below = Math.max(-z, 0);
        const x = u + (u < 0 ? below : -below);
        const y = v + (v < 0 ? below : -below);
        const length = Math.hypot(x, y, z);
        normal.set([x / length, y / length, z / length], 3 * i);
    }
    return { position, normal };
}

// Each triangle with vertices of its own: the shader tells it by the vertex's number.
function expand(bytes: Uint8Array, nTriangles: number, vertices: Vertices): Vertices {
    const n = 3 * nTriangles;
    const nVertices = vertices.position.length / 3;
    const position = new Float32Array(3 * n);
    const normal = new Float32Array(3 * n);
    let next = 0;
    for (let i = 0; i < n; i++) {
        const back = bytes[i] | (bytes[n + i] << 8) | (bytes[2 * n + i] << 16);
        const vertex = next - back;
        if (vertex < 0 || vertex >= nVertices) throw damaged();
        if (back === 0) next++;
        for (let k = 0; k < 3; k++) {
            position[3 * i + k] = vertices.position[3 * vertex + k];
            normal[3 * i + k] = vertices.normal[3 * vertex + k];
        }
    }
    return { position, normal };
}

function atlasSize(nTriangles: number, texelsPerEdge: number): { columns: number; width: number; height: number } {
    const nBlocks = Math.ceil(nTriangles / 2);
    const columns = Math.max(1, Math.min(nBlocks, Math.ceil(Math.sqrt((nBlocks * (texelsPerEdge + 1)) / texelsPerEdge))));
    return { columns, width: columns * texelsPerEdge, height: Math.ceil(nBlocks / columns) * (texelsPerEdge + 1) };
}

// One bit a texel, in the order of triangles and of rows of their lattice, laid out as the atlas.
function readSeen(bytes: Uint8Array, nTriangles: number, texelsPerEdge: number): Uint8Array {
    const { columns, width, height } = atlasSize(nTriangles, texelsPerEdge);
    const seen = new Uint8Array(width * height);
    let texel = 0;
    for (let triangle = 0; triangle < nTriangles; triangle++) {
        const block = triangle >> 1;
        const x0 = (block % columns) * texelsPerEdge;
        const y0 = Math.floor(block / columns) * (texelsPerEdge + 1);
        for (let j = 0; j < texelsPerEdge; j++)
            for (let i = 0; i + j < texelsPerEdge; i++, texel++) {
                if (!((bytes[texel >> 3] >> (texel & 7)) & 1)) continue;
                const x = triangle & 1 ? x0 + texelsPerEdge - 1 - i : x0 + i;
                const y = triangle & 1 ? y0 + texelsPerEdge - j : y0 + j;
                seen[y * width + x] = 255;
            }
    }
    return seen;
}

// The JSON text of a page (docs/viewer.md), as far as it is used here.
interface Numbers {
    n_vertices: number;
    n_triangles: number;
    texels_per_edge: number;
    filled?: boolean;
    columns: number;
    normals_texels_per_edge?: number;
    normals_step_rad?: number;
    rt_board_obj: number[];
    focal_per_width: number;
    min_obj: number[];
    max_obj: number[];
    board_size_px?: number[];
    board_white?: number;
    model: {
        moving: string;
        rt_world_obj: number[];
        rt_world_cam?: number[];
        irradiance?: { harmonics_rgb: number[][]; lamps: number[][] };
        n_hemisphere: number;
        nodes: { radiance: number[]; direction_world: number[][] };
        k_s: number;
        sigma_rad: number;
        light_rgb: number[];
        shadows: boolean;
        lamps?: {
            origin_world: number[];
            tail: number;
            fresnel: number;
            lights: { direction_world: number[]; inverse_distance_per_m: number; radius_rad: number; rgb: number[] }[];
        };
        gloss?: { width: number; colours: number[][] };
        surroundings?: {
            f0: number;
            ambient_rgb: number[][];
            table_rgb: number[];
            board?: { x0_m: number; y0_m: number; pitch_m: number };
        };
    };
}

function vector(x: unknown, n: number): boolean {
    return Array.isArray(x) && x.length === n && x.every(Number.isFinite);
}

// A number that may be divided by and drawn with; JSON's 1e999 is read as infinity.
function positive(x: unknown): boolean {
    return Number.isFinite(x) && (x as number) > 0;
}

function atLeast0(x: unknown): boolean {
    return Number.isFinite(x) && (x as number) >= 0;
}

function irradianceIsGood({ harmonics_rgb, lamps }: NonNullable<Numbers["model"]["irradiance"]>): boolean {
    const lists = Array.isArray(harmonics_rgb) && harmonics_rgb.length <= 9 && Array.isArray(lamps) && lamps.length <= mostSuns;
    return lists && harmonics_rgb.every((x) => vector(x, 3)) && lamps.every((x) => vector(x, 7));
}

function readNumbers(text: Uint8Array): Numbers {
    let n: Numbers;
    try {
        n = JSON.parse(new TextDecoder().decode(text)) as Numbers;
    } catch {
        throw damaged();
    }
    const m = n?.model;
    const around = m?.surroundings;
    const good =
        Number.isSafeInteger(n?.n_vertices) && n.n_vertices > 0 && Number.isSafeInteger(n.n_triangles) && n.n_triangles > 0 &&
        Number.isSafeInteger(n.texels_per_edge) && n.texels_per_edge >= 2 && n.texels_per_edge <= 64 &&
        vector(n.rt_board_obj, 6) && positive(n.focal_per_width) && vector(n.min_obj, 3) && vector(n.max_obj, 3) &&
        vector(m?.rt_world_obj, 6) && atLeast0(m.k_s) && m.sigma_rad >= 1e-5 && m.sigma_rad <= 2 && vector(m.light_rgb, 3) && m.n_hemisphere > 0 && m.n_hemisphere <= mostNodes &&
        Array.isArray(m.nodes?.radiance) && m.nodes.direction_world?.length === m.nodes.radiance.length && m.nodes.radiance.length <= m.n_hemisphere &&
        (!around || (around.f0 >= 0 && around.f0 <= 1 && vector(around.table_rgb, 3) && around.ambient_rgb?.length === 9 && around.ambient_rgb.every((x) => vector(x, 3)))) &&
        (n.normals_texels_per_edge === undefined ||
            (Number.isSafeInteger(n.normals_texels_per_edge) && n.normals_texels_per_edge >= 2 && n.normals_texels_per_edge <= 64 && atLeast0(n.normals_step_rad))) &&
        (m.rt_world_cam === undefined || vector(m.rt_world_cam, 6)) &&
        (!m.irradiance || irradianceIsGood(m.irradiance)) &&
        (!m.gloss || (positive(m.gloss.width) && m.gloss.colours?.length <= 32 && m.gloss.colours.every((x) => vector(x, 4)))) &&
        (!around?.board || (positive(around.board.pitch_m) && vector(n.board_size_px, 2) && Number.isFinite(n.board_white)));
    if (!good) throw damaged();
    return n;
}

function readLights(model: Numbers["model"]): { lightDirection: Float32Array; lightWeight: Float32Array } {
    const n = model.nodes.radiance.length;
    const lightDirection = new Float32Array(3 * n);
    const lightWeight = new Float32Array(n);
    for (let i = 0; i < n; i++) {
        const d = model.nodes.direction_world[i];
        if (!vector(d, 3) || !(Math.hypot(...d) > 0) || !atLeast0(model.nodes.radiance[i])) throw damaged();
        lightWeight[i] = ((2 * Math.PI) / model.n_hemisphere) * model.nodes.radiance[i];
        const length = Math.hypot(...d);
        lightDirection.set(d.map((x) => x / length), 3 * i);
    }
    return { lightDirection, lightWeight };
}

function readLamps(model: Numbers["model"]): Lamps | null {
    const lamps = model.lamps;
    if (!lamps) return null;
    if (!vector(lamps.origin_world, 3) || !(lamps.tail >= 0 && lamps.tail <= 1) || !atLeast0(lamps.fresnel) || !Array.isArray(lamps.lights) || lamps.lights.length > mostLamps) throw damaged();
    const lights = lamps.lights.map((l) => {
        if (!vector(l.direction_world, 3) || !(Math.hypot(...l.direction_world) > 0) || !vector(l.rgb, 3) || !atLeast0(l.inverse_distance_per_m) || !atLeast0(l.radius_rad))
            throw damaged();
        const length = Math.hypot(...l.direction_world);
        return { direction: l.direction_world.map((x) => x / length), perMetre: l.inverse_distance_per_m, radius: l.radius_rad, rgb: l.rgb };
    });
    return { origin: lamps.origin_world, tail: lamps.tail, fresnel: lamps.fresnel, lights };
}

function readIrradiance({ irradiance }: Numbers["model"]): Irradiance | null {
    return irradiance
        ? {
              harmonics: Array.from({ length: 9 }, (_, k) => irradiance.harmonics_rgb[k] ?? [0, 0, 0]),
              lamps: irradiance.lamps.map((x) => ({ direction: x.slice(0, 3), rgb: x.slice(3, 6), perMetre: x[6] })),
          }
        : null;
}

async function readPicture(id: string, width: number, height: number): Promise<ImageBitmap> {
    let bitmap: ImageBitmap;
    try {
        bitmap = await createImageBitmap(new Blob([fromBase64(id)], { type: "image/avif" }), {
            premultiplyAlpha: "none",
            colorSpaceConversion: "none",
        });
    } catch {
        throw new ModelError("A picture in this page is damaged, or this browser does not read AVIF. Was the page saved or sent incompletely?");
    }
    if (bitmap.width !== width || bitmap.height !== height) throw damaged();
    return bitmap;
}

async function readSurroundings(numbers: Numbers): Promise<Surroundings | null> {
    const around = numbers.model.surroundings;
    if (!around) return null;
    const { board } = around;
    const [width, height] = numbers.board_size_px ?? [0, 0];
    return {
        f0: around.f0,
        ambientRgb: around.ambient_rgb,
        tableRgb: around.table_rgb,
        board: board
            ? {
                  picture: await readPicture("board", width, height),
                  x0: board.x0_m,
                  y0: board.y0_m,
                  pitch: board.pitch_m,
                  white: numbers.board_white ?? 1,
              }
            : null,
    };
}

// progress: 0 to 1.
export async function readModel(progress: (share: number) => Promise<void>): Promise<Model> {
    const bytes = await inflate(fromBase64("geometry"));
    await progress(0.2);
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    let at = 8;
    if (bytes.length < at) throw damaged();
    if (view.getUint32(0, true) !== magic) throw new ModelError("The model in this page is of a version that its viewer does not know, or damaged.");
    const take = (n: number): Uint8Array => bytes.subarray(at, (at += n));
    const numbers = readNumbers(take(view.getUint32(4, true)));
    const { n_vertices: nVertices, n_triangles: nTriangles, texels_per_edge: texelsPerEdge, model } = numbers;
    const size = atlasSize(nTriangles, texelsPerEdge);
    const nTexels = nTriangles * ((texelsPerEdge * (texelsPerEdge + 1)) / 2);
    const perEdge = numbers.normals_texels_per_edge ?? 0;
    const normalBytes = 4 * nTriangles * ((perEdge * (perEdge + 1)) / 2);
    if (numbers.columns !== size.columns || bytes.length !== at + 10 * nVertices + 9 * nTriangles + Math.ceil(nTexels / 8) + normalBytes) throw damaged();

    const [low, high] = [numbers.min_obj, numbers.max_obj];
    const vertices = readVertices(take(10 * nVertices), nVertices, low, high);
    await progress(0.4);
    const expanded = expand(take(9 * nTriangles), nTriangles, vertices);
    const seen = readSeen(take(Math.ceil(nTexels / 8)), nTriangles, texelsPerEdge);
    await progress(0.5);
    const normalMap = perEdge ? readNormalMap(take(normalBytes), expanded.normal, perEdge, numbers.normals_step_rad ?? 0) : null;
    await progress(0.6);
    const centre = low.map((x, k) => 0.5 * (x + high[k]));
    let radius = 0;
    for (let i = 0; i < nVertices; i++) {
        const [x, y, z] = [0, 1, 2].map((k) => vertices.position[3 * i + k] - centre[k]);
        radius = Math.max(radius, Math.hypot(x, y, z));
    }
    return {
        nTriangles,
        ...expanded,
        normalMap,
        texelsPerEdge,
        ...size,
        filled: numbers.filled === true,
        seen,
        texture: await readPicture("texture", size.width, size.height),
        ...readLights(model),
        objectMoves: model.moving === "object",
        kS: model.k_s,
        sigma: model.sigma_rad,
        lightRgb: model.light_rgb,
        shadows: model.shadows,
        lamps: readLamps(model),
        gloss: model.gloss ?? null,
        surroundings: await readSurroundings(numbers),
        irradiance: readIrradiance(model),
        worldFromObj: model.rt_world_obj,
        worldFromCam: model.rt_world_cam ?? [0, 0, 0, 0, 0, 0],
        boardFromObj: numbers.rt_board_obj,
        focalPerWidth: numbers.focal_per_width,
        centre,
        radius,
    };
}
