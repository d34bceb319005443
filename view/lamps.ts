// SPDX-License-Identifier: Apache-2.0
// lamps.ts - lamps as a table for the shader: discs taken apart into points, as render/lamp.h and render/lamp.c have it.
import type { Lamp, Lamps } from "./model";

const turn = 2.39996323;

export function pointCount(radius: number, sigma: number): number {
    const ratio = radius / sigma;
    return ratio < 0.05 ? 1 : ratio < 1 ? 8 : ratio < 2 ? 16 : ratio < 4 ? 32 : ratio < 8 ? 64 : 128;
}

function cross(a: number[], b: number[]): number[] {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

// a = d x axis of d's smallest component, b = d x a.
function axesAbout(d: number[]): [number[], number[]] {
    const [x, y, z] = d.map(Math.abs);
    const smallest = x <= y && x <= z ? 0 : y <= z ? 1 : 2;
    const a = cross(d, [0, 1, 2].map((k) => (k === smallest ? 1 : 0)));
    const length = Math.hypot(...a);
    const unit = a.map((v) => v / length);
    return [unit, cross(d, unit)];
}

function pointsOf(lamp: Lamp, n: number): number[][] {
    const [a, b] = axesAbout(lamp.direction);
    return Array.from({ length: n }, (_, k) => {
        const r = n > 1 ? lamp.radius * Math.sqrt((k + 0.5) / n) : 0;
        return lamp.direction.map((d, i) => d + r * (Math.cos(turn * k) * a[i] + Math.sin(turn * k) * b[i]));
    });
}

// Entries of four numbers: for each lamp direction and inverse distance; colour; first point, how many, alpha^2 beyond which the
// direction stands for all. Then the points.
export function lampTable(lamps: Lamps | null, sigma: number): Float32Array {
    const head: number[] = [];
    const points: number[] = [];
    const n = lamps?.lights.length ?? 0;
    for (const lamp of lamps?.lights ?? []) {
        const count = pointCount(lamp.radius, sigma);
        const far = 6 * sigma + 0.75 * lamp.radius;
        head.push(...lamp.direction, lamp.perMetre, ...lamp.rgb, 0, 3 * n + points.length / 4, count, far * far, 0);
        for (const p of pointsOf(lamp, count)) points.push(...p, 0);
    }
    return new Float32Array([...head, ...points]);
}
