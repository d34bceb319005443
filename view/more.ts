// SPDX-License-Identifier: Apache-2.0
// more.ts - what a page knows besides the model: where to look from at first, and photographs to compare with.
export interface Photograph {
    name: string;
    rtCamObj: number[]; // Rodrigues vector, translation
    src: string;
}

export interface More {
    firstView: [number, number]; // azimuth and elevation, degrees
    photographs: Photograph[];
    aspect: number; // of the photographs
    state: string | null; // where the server says whether the model has changed
}

const numbers = (x: unknown, n: number): x is number[] => Array.isArray(x) && x.length === n && x.every(Number.isFinite);

// Whatever is not as it should be is left out: the object can be shown without.
export function readMore(): More {
    const more: More = { firstView: [30, 25], photographs: [], aspect: 1, state: null };
    try {
        const text = JSON.parse(document.getElementById("more")?.textContent ?? "{}") as Record<string, unknown>;
        if (numbers(text.first_view_deg, 2)) more.firstView = [text.first_view_deg[0], text.first_view_deg[1]];
        if (typeof text.state === "string") more.state = text.state;
        if (typeof text.photograph_aspect === "number" && text.photograph_aspect > 0) {
            more.aspect = text.photograph_aspect;
            for (const p of Array.isArray(text.photographs) ? (text.photographs as Record<string, unknown>[]) : [])
                if (numbers(p.rt_cam_obj, 6) && typeof p.src === "string")
                    more.photographs.push({ name: String(p.name), rtCamObj: p.rt_cam_obj, src: p.src });
        }
    } catch {
        // nothing more is known
    }
    return more;
}
