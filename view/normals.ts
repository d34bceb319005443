// SPDX-License-Identifier: Apache-2.0
// normals.ts - the normal map of a packed page as a table for the shader (render/page_normals.c is its writer).
import { DataUtils } from "three";

// Axes square to m that follow it smoothly.
function axesAcross([x, y, z]: number[]): [number[], number[]] {
    if (!(z > -0.9999999)) return [[0, -1, 0], [-1, 0, 0]];
    const k = 1 / (1 + z);
    return [[1 - x * x * k, -x * y * k, -x], [-x * y * k, 1 - y * y * k, -y]];
}

export interface NormalMap {
    texelsPerEdge: number;
    offset: Uint16Array; // [nTriangles][texels of a triangle][4], half floats, the last 0
}

// bytes: two numbers of 16 bits a texel, each in a plane of low and one of high bytes, as folded differences; normal: of each triangle's
// corners, [nTriangles][3][3].
export function readNormalMap(bytes: Uint8Array, normal: Float32Array, texelsPerEdge: number, step: number): NormalMap {
    const nTriangles = normal.length / 9;
    const n = nTriangles * ((texelsPerEdge * (texelsPerEdge + 1)) / 2);
    const offset = new Uint16Array(4 * n);
    // A texel is told from the one before it in its row; the first of a row from the first of the row before, and the first of a triangle
    // from that of the triangle before.
    const before = [[0, 0], [0, 0], [0, 0]];
    const last = texelsPerEdge - 1;
    let texel = 0;
    for (let triangle = 0; triangle < nTriangles; triangle++)
        for (let j = 0; j <= last; j++)
            for (let i = 0; i + j <= last; i++, texel++) {
                const which = i ? 0 : j ? 1 : 2;
                const code = before[which].map((was, k) => {
                    const folded = bytes[2 * k * n + texel] | (bytes[(2 * k + 1) * n + texel] << 8);
                    return (was + ((folded >> 1) ^ (folded & 1 ? 0xffff : 0))) & 0xffff;
                });
                before.fill(code, 0, which + 1);
                const part = code.map((x) => Math.max(-1, Math.min(1, step * ((x << 16) >> 16))));
                const weight = [last - i - j, i, j];
                const m = [0, 1, 2].map((c) => weight.reduce((sum, w, corner) => sum + w * normal[9 * triangle + 3 * corner + c], 0));
                const length = Math.hypot(...m) || 1;
                const [a, b] = axesAcross(m.map((x) => x / length));
                for (let c = 0; c < 3; c++) offset[4 * texel + c] = DataUtils.toHalfFloat(part[0] * a[c] + part[1] * b[c]);
            }
    return { texelsPerEdge, offset };
}
