// SPDX-License-Identifier: Apache-2.0
// bvh.ts - the mesh as a tree of boxes that a shader can walk: what hides a light, and what a surface mirrors of itself.
//
// Split by the surface-area heuristic over bins of the triangles' centres. The tree is laid out depth first, and each
// node knows where to go on when its box is missed, so that a walk needs no stack.
export interface Bvh {
    node: Float32Array; // [n][8]: least x y z, where to go on; greatest x y z, triangles of a leaf (first * 8 + count; -1: none)
    triangle: Float32Array; // [nTriangles][12]: corner 0, its number; edges to corners 1 and 2, each with a 0
}

const mostInLeaf = 4; // fewer than 8
const nBins = 12;

class Box {
    low = [Infinity, Infinity, Infinity];
    high = [-Infinity, -Infinity, -Infinity];

    addPoint(p: ArrayLike<number>, at: number): void {
        for (let k = 0; k < 3; k++) {
            this.low[k] = Math.min(this.low[k], p[at + k]);
            this.high[k] = Math.max(this.high[k], p[at + k]);
        }
    }

    addBox(box: Box): void {
        this.addPoint(box.low, 0);
        this.addPoint(box.high, 0);
    }

    area(): number {
        const [x, y, z] = [0, 1, 2].map((k) => Math.max(0, this.high[k] - this.low[k]));
        return x * y + y * z + z * x;
    }
}

class Builder {
    readonly order: Uint32Array;
    readonly node: number[] = [];
    private readonly centre: Float32Array;

    constructor(private readonly position: Float32Array) {
        const n = position.length / 9;
        this.order = Uint32Array.from({ length: n }, (_, i) => i);
        this.centre = new Float32Array(3 * n);
        for (let i = 0; i < 3 * n; i++) {
            const at = 9 * Math.floor(i / 3) + (i % 3);
            this.centre[i] = (position[at] + position[at + 3] + position[at + 6]) / 3;
        }
    }

    private grow(box: Box, triangle: number): void {
        for (let corner = 0; corner < 3; corner++) box.addPoint(this.position, 9 * triangle + 3 * corner);
    }

    // Where to cut order[begin..end) along its centres' longest axis; begin where a leaf is as good.
    private cut(begin: number, end: number): number {
        const centres = new Box();
        for (let i = begin; i < end; i++) centres.addPoint(this.centre, 3 * this.order[i]);
        const extent = [0, 1, 2].map((k) => centres.high[k] - centres.low[k]);
        const axis = extent.indexOf(Math.max(...extent));
        if (!(extent[axis] > 0)) return begin + ((end - begin) >> 1);
        const binOf = (triangle: number): number =>
            Math.min(nBins - 1, Math.floor(((this.centre[3 * triangle + axis] - centres.low[axis]) / extent[axis]) * nBins));
        const bins = Array.from({ length: nBins }, () => ({ box: new Box(), count: 0 }));
        for (let i = begin; i < end; i++) {
            const bin = bins[binOf(this.order[i])];
            this.grow(bin.box, this.order[i]);
            bin.count++;
        }
        const sweep = (side: typeof bins): number[] => {
            const box = new Box();
            let count = 0;
            return side.map((bin) => {
                box.addBox(bin.box);
                count += bin.count;
                return count ? box.area() * count : 0;
            });
        };
        const left = sweep(bins);
        const right = sweep([...bins].reverse()).reverse();
        let best = 1;
        for (let k = 2; k < nBins; k++) if (left[k - 1] + right[k] < left[best - 1] + right[best]) best = k;
        let middle = begin;
        for (let i = begin; i < end; i++)
            if (binOf(this.order[i]) < best) {
                [this.order[i], this.order[middle]] = [this.order[middle], this.order[i]];
                middle++;
            }
        return middle > begin && middle < end ? middle : begin + ((end - begin) >> 1);
    }

    build(begin: number, end: number): void {
        const box = new Box();
        for (let i = begin; i < end; i++) this.grow(box, this.order[i]);
        const at = this.node.length;
        const leaf = end - begin <= mostInLeaf;
        this.node.push(...box.low, 0, ...box.high, leaf ? begin * 8 + (end - begin) : -1);
        if (!leaf) {
            const middle = this.cut(begin, end);
            this.build(begin, middle);
            this.build(middle, end);
        }
        this.node[at + 3] = this.node.length / 8;
    }
}

// position: [nTriangles][3][3].
export function makeBvh(position: Float32Array): Bvh {
    const builder = new Builder(position);
    builder.build(0, position.length / 9);
    const triangle = new Float32Array(12 * builder.order.length);
    builder.order.forEach((number, i) => {
        const p = position.subarray(9 * number, 9 * number + 9);
        triangle.set([p[0], p[1], p[2], number, p[3] - p[0], p[4] - p[1], p[5] - p[2], 0, p[6] - p[0], p[7] - p[1], p[8] - p[2], 0], 12 * i);
    });
    return { node: new Float32Array(builder.node), triangle };
}
