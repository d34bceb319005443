// SPDX-License-Identifier: Apache-2.0
// model.ts - the packed model of the page, read (docs/viewer.md is the format; render/page_unpack.c its other reader).

export interface Model {
    nTriangles: number;
    position: Float32Array; // [nTriangles][3][3], frame of the object, metres
    normal: Float32Array;
    texelsPerEdge: number;
    columns: number; // blocks in a row of the atlas
    width: number; // of the atlas, px
    height: number;
    seen: Uint8Array; // [height][width]: 255 where a photograph saw the texel
    texture: ImageBitmap;
    lightDirection: Float32Array; // [nLights][3], unit, frame of the lights ("world")
    lightWeight: Float32Array;
    objectMoves: boolean; // the lights stand still before the camera
    kS: number;
    sigma: number; // rad
    lightRgb: number[];
    worldFromObj: number[]; // Rodrigues vector, translation
    boardFromObj: number[];
    focalPerWidth: number;
    centre: number[]; // of the object, in its frame
    radius: number;
}

const magic = 0x314e4853;
const nInts = 8;
const nReals = 24;

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

async function inflate(packed: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    try {
        return new Uint8Array(await new Response(stream).arrayBuffer());
    } catch {
        throw damaged();
    }
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

function readLights(view: DataView, n: number): { lightDirection: Float32Array; lightWeight: Float32Array } {
    const lightDirection = new Float32Array(3 * n);
    const lightWeight = new Float32Array(n);
    for (let i = 0; i < n; i++) {
        const d = [0, 2, 4].map((at) => view.getInt16(10 * i + at, true));
        const length = Math.hypot(...d);
        lightWeight[i] = view.getFloat32(10 * i + 6, true);
        if (!(length > 0) || !(lightWeight[i] >= 0) || !Number.isFinite(lightWeight[i])) throw damaged();
        lightDirection.set(d.map((x) => x / length), 3 * i);
    }
    return { lightDirection, lightWeight };
}

async function readTexture(width: number, height: number): Promise<ImageBitmap> {
    let bitmap: ImageBitmap;
    try {
        bitmap = await createImageBitmap(new Blob([fromBase64("texture")], { type: "image/webp" }), {
            premultiplyAlpha: "none",
            colorSpaceConversion: "none",
        });
    } catch {
        throw damaged();
    }
    if (bitmap.width !== width || bitmap.height !== height) throw damaged();
    return bitmap;
}

// progress: 0 to 1.
export async function readModel(progress: (share: number) => Promise<void>): Promise<Model> {
    const bytes = await inflate(fromBase64("geometry"));
    await progress(0.2);
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    let at = 4 * nInts + 8 * nReals;
    if (bytes.length < at) throw damaged();
    const ints = Array.from({ length: nInts }, (_, i) => view.getUint32(4 * i, true));
    const reals = Array.from({ length: nReals }, (_, i) => view.getFloat64(4 * nInts + 8 * i, true));
    const [found, nVertices, nTriangles, texelsPerEdge, columns, nLights, moving] = ints;
    if (found !== magic) throw new ModelError("The model in this page is of a version that its viewer does not know.");
    if (!reals.every(Number.isFinite) || !nTriangles || texelsPerEdge < 2 || texelsPerEdge > 64) throw damaged();
    const size = atlasSize(nTriangles, texelsPerEdge);
    const nTexels = nTriangles * ((texelsPerEdge * (texelsPerEdge + 1)) / 2);
    if (columns !== size.columns || bytes.length !== at + 10 * nVertices + 9 * nTriangles + 10 * nLights + Math.ceil(nTexels / 8))
        throw damaged();
    const take = (n: number): Uint8Array => bytes.subarray(at, (at += n));

    const low = reals.slice(18, 21);
    const high = reals.slice(21, 24);
    const vertices = readVertices(take(10 * nVertices), nVertices, low, high);
    await progress(0.4);
    const expanded = expand(take(9 * nTriangles), nTriangles, vertices);
    const lights = readLights(new DataView(bytes.buffer, bytes.byteOffset + at, 10 * nLights), nLights);
    take(10 * nLights);
    const seen = readSeen(take(Math.ceil(nTexels / 8)), nTriangles, texelsPerEdge);
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
        texelsPerEdge,
        ...size,
        seen,
        texture: await readTexture(size.width, size.height),
        ...lights,
        objectMoves: moving === 1,
        kS: reals[0],
        sigma: reals[1],
        lightRgb: reals.slice(2, 5),
        worldFromObj: reals.slice(5, 11),
        boardFromObj: reals.slice(11, 17),
        focalPerWidth: reals[17],
        centre,
        radius,
    };
}
