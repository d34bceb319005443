// SPDX-License-Identifier: Apache-2.0
// pick.ts - marks of the mesh's points in frames: two pictures, a cross in each; the server draws, meets and keeps.
export interface Mark {
    frame: string;
    q_px: [number, number];
    mesh_px: [number, number];
}

interface Answer {
    ok: boolean;
    why?: string;
}

const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
const ask = async <T>(what: string): Promise<T> => {
    const answer = await fetch(what, { cache: "no-store" });
    if (!answer.ok) throw new Error(`the station answered ${answer.status}`);
    return (await answer.json()) as T;
};
const say = (text: string): void => {
    element("said").textContent = text;
};
// Whatever fails is said; nothing is half done, because the server keeps the marks.
const doing = (work: Promise<void>): void => void work.catch((error: Error) => say(`That failed: ${error.message}. Is sheen still running?`));

// A picture with a cross that is moved by keys, set by Enter or a click, and marks over it. Places are in its pixels,
// (0, 0) being the centre of the top left one.
class Pane {
    readonly pane: HTMLElement;
    private readonly picture = document.createElement("div");
    private readonly image = new Image();
    private readonly cross = document.createElement("span");
    place: [number, number];
    set = false; // waits for its partner

    constructor(
        id: string,
        private readonly width: number,
        private readonly height: number,
        private readonly onSet: () => void,
    ) {
        this.pane = element(id);
        this.picture.className = "picture";
        this.image.alt = "";
        this.image.draggable = false;
        this.place = [(width - 1) / 2, (height - 1) / 2];
        this.picture.append(this.image, this.cross);
        this.pane.append(this.picture);
        this.image.addEventListener("click", (event) => {
            const box = this.image.getBoundingClientRect();
            this.put(((event.clientX - box.left) / box.width) * width - 0.5, ((event.clientY - box.top) / box.height) * height - 0.5);
            this.onSetNow();
        });
        this.pane.addEventListener("keydown", (event) => this.key(event));
        this.show();
    }

    private onSetNow(): void {
        this.set = true;
        this.show();
        this.onSet();
    }

    private key(event: KeyboardEvent): void {
        const step = event.shiftKey ? 0.5 : this.width / 80;
        const moves: Record<string, [number, number]> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
        const move = moves[event.key];
        if (move) this.put(this.place[0] + move[0], this.place[1] + move[1]);
        else if (event.key === "Enter") this.onSetNow();
        else return;
        event.preventDefault();
    }

    private put(x: number, y: number): void {
        this.place = [Math.min(this.width - 1, Math.max(0, x)), Math.min(this.height - 1, Math.max(0, y))];
        this.set = false;
        this.show();
        this.cross.scrollIntoView({ block: "nearest", inline: "nearest" });
    }

    private at(span: HTMLElement, [x, y]: [number, number]): void {
        span.style.left = `${(100 * (x + 0.5)) / this.width}%`;
        span.style.top = `${(100 * (y + 0.5)) / this.height}%`;
    }

    show(): void {
        this.cross.className = this.set ? "cross set" : "cross";
        this.at(this.cross, this.place);
    }

    source(src: string): void {
        this.image.src = src;
    }

    zoom(factor: number): void {
        this.picture.style.width = factor > 0 ? `${this.width * factor}px` : "100%";
        this.cross.scrollIntoView({ block: "center", inline: "center" });
    }

    labels(marks: [string, [number, number]][]): void {
        for (const old of this.picture.querySelectorAll("span:not(.cross)")) old.remove();
        for (const [name, place] of marks) {
            const span = document.createElement("span");
            const label = document.createElement("b");
            label.textContent = name;
            span.append(label);
            this.at(span, place);
            this.picture.append(span);
        }
    }
}

async function start(): Promise<void> {
    const facts = await ask<{ frames: string[]; width_px: number; height_px: number; mesh_side_px: number }>("frames");
    const which = element<HTMLSelectElement>("which");
    let view: [number, number] = [30, 20];
    const mesh = new Pane("mesh", facts.mesh_side_px, facts.mesh_side_px, () => doing(pair()));
    const frame = new Pane("frame", facts.width_px, facts.height_px, () => doing(pair()));

    const refresh = async (): Promise<void> => {
        const { marks, rms_px, worst_px, worst, why } = await ask<{ marks: Mark[]; rms_px?: number; worst_px?: number; worst?: number; why?: string }>(`marks/${view.join("/")}`);
        const name = facts.frames[which.selectedIndex];
        const all = marks.map((mark, i) => ({ ...mark, label: String(i + 1) }));
        mesh.labels(all.map((mark) => [mark.label, mark.mesh_px]));
        frame.labels(all.filter((mark) => mark.frame === name).map((mark) => [mark.label, mark.q_px]));
        element<HTMLButtonElement>("undo").disabled = !marks.length;
        const n = `${marks.length} ${marks.length === 1 ? "mark" : "marks"}`;
        if (rms_px === undefined) say(`${n}. ${why ?? ""}`);
        else say(`${n}, which fit to ${rms_px.toFixed(1)} px; the worst, mark ${worst}, to ${worst_px?.toFixed(1)} px. Saved; Ctrl-C in the terminal when they are enough.`);
    };
    const draw = async (): Promise<void> => {
        mesh.source(`mesh/${view.join("/")}`);
        await refresh();
    };
    const turn = (azimuth: number, elevation: number): void => {
        view = [(view[0] + azimuth + 360) % 360, Math.min(90, Math.max(-90, view[1] + elevation))];
        mesh.set = false;
        mesh.show();
        doing(draw());
    };
    const pair = async (): Promise<void> => {
        if (!mesh.set || !frame.set) return;
        mesh.set = frame.set = false;
        const answer = await ask<Answer>(["mark", which.selectedIndex, ...frame.place, ...view, ...mesh.place].join("/"));
        mesh.show();
        frame.show();
        await refresh();
        if (!answer.ok) say(`Not taken: ${answer.why}.`);
    };

    facts.frames.forEach((name) => which.add(new Option(name)));
    which.addEventListener("change", () => {
        frame.set = false;
        frame.show();
        frame.source(`frame/${which.selectedIndex}`);
        doing(refresh());
    });
    element<HTMLSelectElement>("size").addEventListener("change", (event) => frame.zoom(Number((event.target as HTMLSelectElement).value)));
    element("undo").addEventListener("click", () => doing(ask<Answer>("undo").then(refresh)));
    for (const button of document.querySelectorAll<HTMLButtonElement>("[data-turn]"))
        button.addEventListener("click", () => {
            const [azimuth, elevation] = (button.dataset.turn ?? "0,0").split(",").map(Number);
            turn(azimuth, elevation);
        });
    mesh.pane.addEventListener("keydown", (event) => {
        const turns: Record<string, [number, number]> = { a: [-15, 0], d: [15, 0], w: [0, 15], s: [0, -15] };
        const by = event.ctrlKey || event.metaKey || event.altKey ? undefined : turns[event.key.toLowerCase()];
        if (by) turn(...by);
    });
    frame.source("frame/0");
    await draw();
    document.documentElement.dataset.state = "ready";
}

doing(start());
