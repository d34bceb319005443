// SPDX-License-Identifier: Apache-2.0
// controls.ts - turning, moving and zooming by mouse, touch and keyboard.
import type { View } from "./view";

export interface Motion {
    turn: (right: number, down: number) => void; // degrees
    move: (right: number, down: number) => void; // shares of the picture's width
    zoom: (factor: number) => void; // of the distance
    home: () => void;
}

// What changes in a view; the limits are in radii of the object.
export function motionOn(get: () => View, set: (view: View) => void, home: () => void, radius: number, focalPerWidth: number): Motion {
    const within = (x: number, most: number): number => Math.min(most, Math.max(-most, x));
    return {
        turn(right, down) {
            const view = get();
            set({ ...view, azimuth: (view.azimuth - right) % 360, elevation: within(view.elevation + down, 90) });
        },
        move(right, down) {
            const view = get();
            const metres = view.distance / focalPerWidth;
            set({ ...view, pan: [within(view.pan[0] + right * metres, 5 * radius), within(view.pan[1] + down * metres, 5 * radius)] });
        },
        zoom(factor) {
            const view = get();
            set({ ...view, distance: Math.min(50 * radius, Math.max(1.02 * radius, view.distance * factor)) });
        },
        home,
    };
}

const degreesAcross = 240; // a drag over the picture's whole width

function onPointers(canvas: HTMLCanvasElement, motion: Motion): void {
    const held = new Map<number, { x: number; y: number }>();
    const spread = (): number => {
        const [a, b] = [...held.values()];
        return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        held.set(event.pointerId, { x: event.clientX, y: event.clientY });
        canvas.classList.add("held");
    });
    const release = (event: PointerEvent): void => {
        held.delete(event.pointerId);
        if (!held.size) canvas.classList.remove("held");
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", (event) => {
        const last = held.get(event.pointerId);
        if (!last) return;
        const before = held.size === 2 ? spread() : 0;
        const right = (event.clientX - last.x) / canvas.clientWidth;
        const down = (event.clientY - last.y) / canvas.clientWidth;
        held.set(event.pointerId, { x: event.clientX, y: event.clientY });
        if (held.size === 2) {
            motion.move(right / 2, down / 2);
            const after = spread();
            if (before > 0 && after > 0) motion.zoom(before / after);
        } else if (held.size === 1) {
            if (event.shiftKey || event.buttons & 6) motion.move(right, down);
            else motion.turn(right * degreesAcross, down * degreesAcross);
        }
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener(
        "wheel",
        (event) => {
            event.preventDefault();
            const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 40 : event.deltaY;
            motion.zoom(Math.exp(0.04 * Math.min(10, Math.max(-10, lines))));
        },
        { passive: false },
    );
}

function onKeys(canvas: HTMLCanvasElement, motion: Motion): void {
    const arrows: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    canvas.addEventListener("keydown", (event) => {
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        const arrow = arrows[event.key];
        if (arrow && event.shiftKey) motion.move(0.02 * arrow[0], 0.02 * arrow[1]);
        else if (arrow) motion.turn(5 * arrow[0], 5 * arrow[1]);
        else if (event.key === "+" || event.key === "=") motion.zoom(1 / 1.1);
        else if (event.key === "-") motion.zoom(1.1);
        else if (event.key === "Home") motion.home();
        else return;
        event.preventDefault();
    });
}

export function listen(canvas: HTMLCanvasElement, motion: Motion): void {
    onPointers(canvas, motion);
    onKeys(canvas, motion);
}
