// SPDX-License-Identifier: Apache-2.0
// main.ts - the page: reads the model, draws it, and connects what a person can do with it.
import { listen, motionOn } from "./controls";
import { drawHemisphere } from "./hemisphere";
import { type Model, ModelError, readModel } from "./model";
import { Stage } from "./scene";
import { firstView, fromHash, toHash, type View } from "./view";

const degreesPerSecond = 24; // of the turntable
const root = document.documentElement;

function element<T extends HTMLElement>(id: string): T {
    return document.getElementById(id) as T;
}

function fail(text: string): void {
    root.dataset.state = "error";
    element("message-text").textContent = text;
}

// Shows how far loading is, and lets the browser paint it.
async function progress(share: number): Promise<void> {
    element<HTMLProgressElement>("bar").value = share;
    await new Promise((resolve) => setTimeout(resolve, 0));
}

class Page {
    private readonly canvas = element<HTMLCanvasElement>("stage");
    private readonly stage: Stage;
    private readonly first: View;
    private view: View;
    private moving = false; // drawn coarsely until things stand still
    private turning = false;
    private complete = false;
    private last = 0; // time of the last frame, ms
    private movedAt = 0;

    constructor(private readonly model: Model) {
        this.stage = new Stage(this.canvas, model);
        this.stage.resize();
        this.first = firstView(model, this.canvas.width, this.canvas.height);
        this.view = fromHash(location.hash, this.first, model.radius);
        if (new URLSearchParams(location.hash.slice(1)).get("interface") === "none") root.dataset.interface = "none";
        const home = (): void => this.show({ ...this.view, ...this.viewpoint(this.first) });
        listen(this.canvas, motionOn(() => this.view, (view) => this.show(view), home, model.radius, model.focalPerWidth));
        this.connectForm();
        this.connectButtons();
        addEventListener("resize", () => this.show({ ...this.view }));
        addEventListener("hashchange", () => this.show(fromHash(location.hash, this.first, model.radius)));
        this.canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault();
            fail("The browser took the graphics away. Reload the page to see the object again.");
        });
        this.fillForm();
        // The first picture is drawn here, so that a shader that does not compile is noticed.
        while (!this.stage.drawStill(this.view));
        requestAnimationFrame((now) => this.frame(now));
    }

    private viewpoint(view: View): Pick<View, "azimuth" | "elevation" | "distance" | "pan"> {
        return { azimuth: view.azimuth, elevation: view.elevation, distance: view.distance, pan: view.pan };
    }

    private show(view: View): void {
        this.view = view;
        this.moving = true;
        this.complete = false;
        this.movedAt = performance.now();
        this.fillForm();
    }

    private frame(now: number): void {
        const elapsed = this.last ? (now - this.last) / 1000 : 0;
        this.last = now;
        if (this.stage.resize()) this.show(this.view);
        if (this.turning)
            this.show({ ...this.view, azimuth: (this.view.azimuth + Math.min(elapsed, 0.25) * degreesPerSecond) % 360 });
        if (this.moving) {
            root.dataset.drawn = "moving";
            this.stage.drawMoving(this.view, elapsed);
            this.moving = now - this.movedAt < 120;
        } else if (!this.complete) {
            this.complete = this.stage.drawStill(this.view);
            if (this.complete) {
                root.dataset.drawn = "still";
                this.keepAddress();
            }
        }
        requestAnimationFrame((next) => this.frame(next));
    }

    private keepAddress(): void {
        const none = root.dataset.interface === "none" ? "&interface=none" : "";
        try {
            history.replaceState(null, "", toHash(this.view, this.first) + none);
        } catch {
            // a page in a frame or from a disk may not be permitted to; the link button still works
        }
    }

    // Controls say what the view is, however it came about.
    private fillForm(): void {
        const { view } = this;
        const set = (id: string, value: number, text: string): void => {
            element<HTMLInputElement>(id).value = String(value);
            element(`${id}-value`).textContent = text;
            element(id).setAttribute("aria-valuetext", text);
        };
        set("strength", view.strength, `${Math.round(100 * view.strength)} %`);
        set("roughness", Math.log10(view.sigma), `σ ${view.sigma.toPrecision(3)} rad`);
        set("lights", view.turn, `${Math.round(view.turn)}°`);
        element<HTMLInputElement>("holes").checked = view.holes;
        for (const radio of document.querySelectorAll<HTMLInputElement>("input[name=layer]")) radio.checked = radio.value === view.layer;
        if (element<HTMLDetailsElement>("hemisphere-part").open)
            drawHemisphere(element<HTMLCanvasElement>("hemisphere"), this.model, view);
    }

    private connectForm(): void {
        const on = (id: string, change: (input: HTMLInputElement) => Partial<View>): void => {
            const input = element<HTMLInputElement>(id);
            input.addEventListener("input", () => this.show({ ...this.view, ...change(input) }));
        };
        on("strength", (input) => ({ strength: input.valueAsNumber }));
        on("roughness", (input) => ({ sigma: 10 ** input.valueAsNumber }));
        on("lights", (input) => ({ turn: input.valueAsNumber }));
        on("holes", (input) => ({ holes: input.checked }));
        for (const radio of document.querySelectorAll<HTMLInputElement>("input[name=layer]"))
            radio.addEventListener("input", () => this.show({ ...this.view, layer: radio.value as View["layer"] }));
        element("controls").addEventListener("submit", (event) => event.preventDefault());
        element("controls").addEventListener("reset", (event) => {
            event.preventDefault();
            this.show({ ...this.first });
        });
        element("hemisphere-part").addEventListener("toggle", () => this.fillForm());
        // On a small screen the object comes first.
        if (matchMedia("(max-width: 560px)").matches) element<HTMLDetailsElement>("panel").open = false;
    }

    private connectButtons(): void {
        const turn = element("turn");
        turn.addEventListener("click", () => {
            this.turning = !this.turning;
            turn.setAttribute("aria-pressed", String(this.turning));
        });
        const full = element("full");
        full.hidden = !document.fullscreenEnabled;
        full.addEventListener("click", () => {
            if (document.fullscreenElement) void document.exitFullscreen();
            else root.requestFullscreen().catch(() => this.say("This browser does not permit full screen here."));
        });
        document.addEventListener("fullscreenchange", () => {
            full.textContent = document.fullscreenElement ? "Leave full screen" : "Full screen";
        });
        element("link").addEventListener("click", () => {
            const link = location.href.replace(/#.*/, "") + toHash(this.view, this.first);
            navigator.clipboard
                ?.writeText(link)
                .then(() => this.say("The link to this view is in the clipboard."))
                .catch(() => this.say(link));
            if (!navigator.clipboard) this.say(link);
        });
    }

    private say(text: string): void {
        element("said").textContent = text;
    }
}

async function main(): Promise<void> {
    element("title").textContent = document.title;
    element("stage").setAttribute("aria-label", document.title);
    const model = await readModel(progress);
    await progress(0.8);
    new Page(model);
    root.dataset.state = "ready";
    root.dataset.drawn = "still";
}

main().catch((error: unknown) => {
    console.error(error);
    fail(error instanceof ModelError ? error.message : `This page could not be shown: ${String(error)}`);
});
