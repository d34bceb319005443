// SPDX-License-Identifier: Apache-2.0
// cells.ts - which lights can matter for which mirror direction: the culling of render/light_cells.c.
//
// Mirror directions are laid on a square by the octahedron and cut into cells. A light counts in a cell when it is
// within 10 sigma of one of its directions: alpha, the angle at the half vector, is at least half the angle between
// mirror direction and light, and beyond 5 sigma of alpha a term is below 4e-6 of its peak.
export interface Cells {
    side: number; // cells along the square; 0: every light counts everywhere
    range: Float32Array; // [side * side][2]: first entry, and the entry after the last
    entry: Float32Array; // [n][4]: direction and weight
}

const reachSigma = 5;
const maxSide = 128;
const maxEntries = 1 << 20;

export function directionOf(u: number, v: number): number[] {
    const z = 1 - Math.abs(u) - Math.abs(v);
    const below = Math.max(-z, 0);
    const x = u + (u < 0 ? below : -below);
    const y = v + (v < 0 ? below : -below);
    const length = Math.hypot(x, y, z);
    return [x / length, y / length, z / length];
}

function angleBetween(a: number[], b: number[]): number {
    const across = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    return Math.atan2(Math.hypot(...across), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

function everything(direction: Float32Array, weight: Float32Array): Cells {
    const entry = new Float32Array(4 * weight.length);
    weight.forEach((w, i) => entry.set([direction[3 * i], direction[3 * i + 1], direction[3 * i + 2], w], 4 * i));
    return { side: 0, range: new Float32Array([0, weight.length]), entry };
}

function listCells(side: number, reach: number, direction: Float32Array, weight: Float32Array): Cells | null {
    const step = 2 / side;
    const range = new Float32Array(2 * side * side);
    const entry: number[] = [];
    for (let row = 0; row < side; row++)
        for (let column = 0; column < side; column++) {
            const u = -1 + step * column;
            const v = -1 + step * row;
            const centre = directionOf(u + 0.5 * step, v + 0.5 * step);
            let radius = 0; // cells are bounded by great circles: their farthest points are corners
            for (let k = 0; k < 4; k++)
                radius = Math.max(radius, angleBetween(centre, directionOf(u + step * (k & 1), v + step * (k >> 1))));
            const angle = radius * 1.0001 + 1e-5 + reach;
            const least = angle < 3.14 ? Math.cos(angle) - 1e-6 : -2;
            const cell = row * side + column;
            range[2 * cell] = entry.length / 4;
            for (let i = 0; i < weight.length; i++) {
                const x = direction[3 * i];
                const y = direction[3 * i + 1];
                const z = direction[3 * i + 2];
                if (weight[i] > 0 && x * centre[0] + y * centre[1] + z * centre[2] >= least) entry.push(x, y, z, weight[i]);
            }
            range[2 * cell + 1] = entry.length / 4;
            if (entry.length > 4 * maxEntries) return null;
        }
    return { side, range, entry: new Float32Array(entry) };
}

export function makeCells(direction: Float32Array, weight: Float32Array, sigma: number): Cells {
    const reach = 2 * reachSigma * sigma;
    if (reach < 1.4) {
        let side = Math.min(maxSide, Math.max(4, Math.floor(1.4 / sigma)));
        for (side -= side % 2; side >= 4; side = 2 * Math.floor(side / 4)) {
            const cells = listCells(side, reach, direction, weight);
            if (cells) return cells;
        }
    }
    return everything(direction, weight);
}
