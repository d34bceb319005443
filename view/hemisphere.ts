// SPDX-License-Identifier: Apache-2.0
// hemisphere.ts - a small map of the lights, seen from above (equal distances from its middle are equal angles), with
// the camera's direction as a ring.
import type { Model } from "./model";
import { apply, poseOf, transpose, type View } from "./view";

export function drawHemisphere(canvas: HTMLCanvasElement, model: Model, view: View): void {
    const context = canvas.getContext("2d");
    if (!context) return;
    const middle = canvas.width / 2;
    const edge = middle - 8;
    const onMap = ([x, y, z]: number[]): [number, number] => {
        const across = Math.hypot(x, y);
        const distance = (Math.atan2(across, z) / (Math.PI / 2)) * edge;
        return across > 0 ? [middle + (x / across) * distance, middle - (y / across) * distance] : [middle, middle];
    };
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.strokeStyle = "#8a8a8a";
    context.fillStyle = "#000";
    context.beginPath();
    context.arc(middle, middle, edge, 0, 2 * Math.PI);
    context.fill();
    context.stroke();

    const angle = (view.turn * Math.PI) / 180;
    const lights = Array.from(model.lightWeight, (weight, i) => ({ weight, direction: Array.from(model.lightDirection.subarray(3 * i, 3 * i + 3)) }));
    for (const lamp of model.lamps?.lights ?? []) lights.push({ weight: Math.max(...lamp.rgb), direction: lamp.direction });
    const most = lights.reduce((a, b) => Math.max(a, b.weight), 0) || 1;
    lights.forEach(({ weight, direction: [x, y, z] }) => {
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        const turned = [c * x - s * y, s * x + c * y, z];
        const [px, py] = onMap(turned);
        context.fillStyle = `rgb(255 240 200 / ${Math.max(0.15, Math.sqrt(weight / most))})`;
        context.beginPath();
        context.arc(px, py, 1 + 2 * Math.sqrt(weight / most), 0, 2 * Math.PI);
        context.fill();
    });

    const pose = poseOf(model, { ...view, turn: 0 });
    const toCamera = apply(pose.lightFromObj, apply(transpose(pose.R), [0, 0, -1]));
    const [px, py] = onMap(toCamera);
    context.strokeStyle = "#8cc8ff";
    context.lineWidth = 2;
    context.beginPath();
    context.arc(px, py, 5, 0, 2 * Math.PI);
    context.stroke();
    context.lineWidth = 1;
    canvas.setAttribute("aria-label", `Map of ${lights.length} lights seen from above; the ring is the camera`);
}
