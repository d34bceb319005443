// SPDX-License-Identifier: Apache-2.0
// view.ts - where the camera stands and what is shown; as text for a link. The viewpoints are those of
// `sheen render --view`: azimuth about the board's z from its x, elevation, distance from the object's middle.
import type { Model } from "./model";
import type { More } from "./more";

export interface View {
    azimuth: number; // degrees
    elevation: number;
    distance: number; // metres
    pan: [number, number]; // metres that the object is moved right and down in the picture
    layer: "all" | "diffuse" | "specular";
    strength: number; // times the model's k_S
    sigma: number; // rad
    turn: number; // of the lights, degrees
    holes: boolean; // marked
    wire: boolean; // the triangles' edges are drawn
    photo: number; // from whose viewpoint, seen as it was taken; -1: none
}

export type Matrix3 = number[][]; // rows

const fill = 0.8; // share of the smaller side that the object's sphere fills
const rad = Math.PI / 180;

export function multiply(a: Matrix3, b: Matrix3): Matrix3 {
    return a.map((row) => [0, 1, 2].map((k) => row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]));
}

export function apply(a: Matrix3, x: number[]): number[] {
    return a.map((row) => row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
}

export function transpose(a: Matrix3): Matrix3 {
    return [0, 1, 2].map((i) => a.map((row) => row[i]));
}

// Of a Rodrigues vector.
export function rotation(r: number[]): Matrix3 {
    const angle = Math.hypot(r[0], r[1], r[2]);
    const [x, y, z] = angle > 0 ? r.slice(0, 3).map((c) => c / angle) : [0, 0, 1];
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    const t = 1 - c;
    return [
        [c + t * x * x, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, c + t * y * y, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, c + t * z * z],
    ];
}

export function defaultDistance(model: Model, width: number, height: number): number {
    const focal = model.focalPerWidth * width;
    return model.radius * Math.hypot(1, focal / ((fill * Math.min(width, height)) / 2));
}

export function firstView(model: Model, more: More, width: number, height: number): View {
    return {
        azimuth: more.firstView[0],
        elevation: more.firstView[1],
        distance: defaultDistance(model, width, height),
        pan: [0, 0],
        layer: "all",
        strength: 1,
        sigma: model.sigma,
        turn: 0,
        holes: false,
        wire: false,
        photo: -1,
    };
}

export interface Pose {
    R: Matrix3; // camera from object; x right, y down, z forward
    t: number[];
    camera: number[]; // in the object's frame
    worldFromObj: Matrix3; // into the frame in which the surroundings stand
    lightFromObj: Matrix3; // the same, turned as the lights are
    lightOrigin: number[];
}

// Where the camera of a photograph stood, as a view about the object.
export function viewOfPhoto(model: Model, rt: number[]): Pick<View, "azimuth" | "elevation" | "distance" | "pan"> {
    const R = rotation(rt);
    const camera = apply(transpose(R), rt.slice(3)).map((x) => -x);
    const d = apply(rotation(model.boardFromObj), camera.map((x, k) => x - model.centre[k]));
    const distance = Math.hypot(...d);
    return {
        azimuth: Math.atan2(d[1], d[0]) / rad,
        elevation: Math.asin(Math.max(-1, Math.min(1, d[2] / distance))) / rad,
        distance,
        pan: [0, 0],
    };
}

export function poseOf(model: Model, view: View, photo: number[] | null = null): Pose {
    const ca = Math.cos(view.azimuth * rad);
    const sa = Math.sin(view.azimuth * rad);
    const ce = Math.cos(view.elevation * rad);
    const se = Math.sin(view.elevation * rad);
    const look = [
        [-sa, ca, 0],
        [se * ca, se * sa, -ce],
        [-ce * ca, -ce * sa, -se],
    ];
    const R = photo ? rotation(photo) : multiply(look, rotation(model.boardFromObj));
    const offset = apply(R, model.centre);
    const t = photo ? photo.slice(3) : [view.pan[0] - offset[0], view.pan[1] - offset[1], view.distance - offset[2]];
    const camera = apply(transpose(R), t).map((x) => -x);
    // Before lights that stand still the camera does, too, and the object has turned to be seen so.
    const worldFromCam = rotation(model.worldFromCam);
    const worldFromObj = model.objectMoves ? multiply(worldFromCam, R) : rotation(model.worldFromObj);
    const worldOrigin = model.objectMoves ? apply(worldFromCam, t).map((x, k) => x + model.worldFromCam[3 + k]) : model.worldFromObj.slice(3);
    const back = rotation([0, 0, -view.turn * rad]); // the lights turn about the board's vertical
    return { R, t, camera, worldFromObj, lightFromObj: multiply(back, worldFromObj), lightOrigin: apply(back, worldOrigin) };
}

function number(text: string | undefined, low: number, high: number, otherwise: number): number {
    const x = Number(text);
    return text && Number.isFinite(x) ? Math.min(high, Math.max(low, x)) : otherwise;
}

const short = (x: number): string => String(Math.abs(x) < 1e-6 ? 0 : Number(x.toPrecision(5)));

// The part of the address after '#'. What is as at first is left out.
export function toHash(view: View, first: View): string {
    const parts = [`view=${[view.azimuth, view.elevation, view.distance].map(short).join(",")}`];
    if (view.pan[0] || view.pan[1]) parts.push(`pan=${view.pan.map(short).join(",")}`);
    if (view.layer !== first.layer) parts.push(`layer=${view.layer}`);
    if (view.strength !== first.strength) parts.push(`strength=${short(view.strength)}`);
    if (view.sigma !== first.sigma) parts.push(`sigma=${short(view.sigma)}`);
    if (view.turn !== first.turn) parts.push(`lights=${short(view.turn)}`);
    if (view.holes) parts.push("holes=marked");
    if (view.wire) parts.push("triangles=shown");
    if (view.photo >= 0) parts.push(`photograph=${view.photo + 1}`);
    return `#${parts.join("&")}`;
}

export function fromHash(hash: string, first: View, radius: number, nPhotos: number): View {
    const given = new URLSearchParams(hash.replace(/^#/, ""));
    const look = (given.get("view") ?? "").split(",");
    const pan = (given.get("pan") ?? "").split(",");
    const layer = given.get("layer");
    const text = (key: string): string | undefined => given.get(key) ?? undefined;
    return {
        azimuth: number(look[0], -1e6, 1e6, first.azimuth),
        elevation: number(look[1], -90, 90, first.elevation),
        distance: number(look[2], 1.02 * radius, 50 * radius, first.distance),
        pan: [number(pan[0], -5 * radius, 5 * radius, 0), number(pan[1], -5 * radius, 5 * radius, 0)],
        layer: layer === "diffuse" || layer === "specular" ? layer : "all",
        strength: number(text("strength"), 0, 4, 1),
        sigma: number(text("sigma"), 1e-3, 1, first.sigma),
        turn: number(text("lights"), -180, 180, 0),
        holes: given.get("holes") === "marked",
        wire: given.get("triangles") === "shown",
        photo: Math.round(number(text("photograph"), 1, nPhotos, 0)) - 1,
    };
}
